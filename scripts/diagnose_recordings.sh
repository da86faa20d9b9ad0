#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/diagnose_recordings.sh [--out DIR] [--jobs J] [FOLDER ...]
#
# Runs hrp-diagnose over folders of real recordings (all in ../shared/recordings when none is named), and beside it the
# plain least-squares identification of viscous and Coulomb friction and rotor inertia. Prints one table and, for the
# folders of ../shared/recordings, puts it between the marks in docs/recordings.md.
#   --out DIR   one folder of answers for each recording (out/recordings)
#   --jobs J    threads of the tool (all cores)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

out=$ROOT/out/recordings jobs=$(nproc) folders=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --out) out=$2; shift 2 ;;
    --jobs) jobs=$2; shift 2 ;;
    -*) fail "unknown option $1; --help lists the known ones" ;;
    *) folders+=("$1"); shift ;;
  esac
done
table_options=()
if [ ${#folders[@]} -eq 0 ]; then
  [ -d "$ROOT/../shared/recordings" ] || fail "no folder named, and ../shared/recordings is not there"
  folders=("$ROOT"/../shared/recordings/*/)
  table_options=(--page "$ROOT/docs/recordings.md")
fi
[ -x "$BUILD/bin/hrp-diagnose" ] && [ -x "$BUILD/bin/hrp-diagnose-baseline" ] ||
  "$ROOT/scripts/build.sh" hrp-diagnose hrp-diagnose-baseline >&2

for folder in "${folders[@]}"; do
  name=$(basename "$folder")
  answer=$out/$name
  rm -rf "$answer"
  mkdir -p "$answer"
  say "$name"
  begin=$(date +%s.%N) status=0
  timeout "${HRP_DIAGNOSE_LIMIT:-900}" "$BUILD/bin/hrp-diagnose" "$folder/experiment.yaml" --out "$answer" --jobs "$jobs" >"$answer/terminal.txt" 2>&1 || status=$?
  end=$(date +%s.%N)
  printf '{"status": %d, "seconds": %s}\n' "$status" "$(awk "BEGIN {printf \"%.1f\", $end - $begin}")" >"$answer/run.json"
  "$BUILD/bin/hrp-diagnose-baseline" "$folder/experiment.yaml" >"$answer/baseline.json" 2>"$answer/baseline.txt" || true
done
python3 "$ROOT/scripts/recordings_table.py" "$out" "${table_options[@]}" "${folders[@]}"
