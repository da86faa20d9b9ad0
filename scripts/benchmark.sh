#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/benchmark.sh [--short] [--out FILE]
#
# Compares the speed with Debian's MuJoCo and DART: forward dynamics, mass matrix, inverse dynamics, whole steps,
# 1000 robots in one process, the server set. Prints one table of median processor times, with machine and versions. The
# engines take turns, because the speed of a machine drifts. docs/performance.md explains the table. No pass or fail.
#   --short     a quarter of the repetitions, and no server set
#   --out FILE  also writes the table to FILE
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
short="" out=""
while [ $# -gt 0 ]; do
  case "$1" in
    --short) short=1; shift ;;
    --out) out="${2:-}"; [ -n "$out" ] || refuse "--out needs a file"; shift 2 ;;
    *) refuse "unknown argument '$1'; --help lists the known ones" ;;
  esac
done

configure -DBUILD_TESTING=ON -DHRP_RUN_ONLY=OFF
run_ninja multibody_benchmark step_benchmark hrp_run_programs hrp-simulate >&2
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
options=(--benchmark_repetitions="${short:+3}" --benchmark_enable_random_interleaving=true --benchmark_format=json)
[ -n "$short" ] || options[0]=--benchmark_repetitions=11
for name in multibody step; do
  say "$name ..."
  "$BUILD/bin/${name}_benchmark" "${options[@]}" --benchmark_min_time="$([ -n "$short" ] && echo 0.05 || echo 0.2)" \
    > "$folder/$name.json" 2> "$folder/$name.txt" || { cat "$folder/$name.txt" >&2; fail "${name}_benchmark failed"; }
done
if [ -z "$short" ]; then
  say "server set ..."
  "$ROOT/tests/benchmark/server_set_benchmark.sh" 10 3 > "$folder/server_set.txt"
fi
python3 "$ROOT/scripts/benchmark_table.py" "$folder" | tee ${out:+"$out"}
