#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/fuzz.sh [TARGET ...] [--runs N] [--seconds N] [--seed N]
#
# Feeds mutated bytes to every reader (libFuzzer, with address and undefined-behaviour sanitizers) and prints a table.
# Targets: cdr csv experiment heights http idl mcap mesh mjcf motion picture recording rosbag scenario sdf urdf websocket.
# It needs clang (apt-get install clang) and builds in build-fuzz, beside the usual build. Status 1 when there is a finding; the
# input lies in build-fuzz/findings.
#
#   --runs N      executions of each target, default 1000000
#   --seconds N   time limit of each target, default none
#   --seed N      default 1. build-fuzz/corpus keeps inputs that reached new code; the next call starts from them
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

runs=1000000 seconds=0 seed=1 targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --runs | --seconds | --seed) [ $# -gt 1 ] || refuse "$1 needs a number"; declare "${1#--}=$2"; shift ;;
    -*) refuse "unknown option $1 (--help)" ;;
    *) targets+=("$1") ;;
  esac
  shift
done
[ ${#targets[@]} -gt 0 ] || targets=(cdr csv experiment heights http idl mcap mesh mjcf motion picture recording rosbag scenario sdf urdf websocket)
for target in "${targets[@]}"; do [ -f "$ROOT/tests/fuzz/$target.cpp" ] || refuse "there is no target $target (--help)"; done
command -v clang++ > /dev/null || fail "clang is missing: apt-get install clang"
export BUILD="${HRP_FUZZ_BUILD_DIR:-$ROOT/build-fuzz}"
mkdir -p "$BUILD"
CC=clang CXX=clang++ cmake -S "$ROOT" -B "$BUILD" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF -DHRP_PRECOMPILE=OFF \
  -DHRP_FUZZ=ON -DHRP_SANITIZE=address,undefined > "$BUILD/configure.log" 2>&1 || { cat "$BUILD/configure.log" >&2; fail "cmake could not configure"; }
ninja -C "$BUILD" "${targets[@]/#/fuzz_}" >&2

# What the sanitizers would say of inputs that are only large: a reader may refuse them with bad_alloc, and does.
export ASAN_OPTIONS="${ASAN_OPTIONS:-allocator_may_return_null=1:detect_leaks=1}"
mkdir -p "$BUILD/findings"
failed=0
printf '| target | executions | seconds | inputs kept | finding |\n|---|---|---|---|---|\n'
for target in "${targets[@]}"; do
  corpus="$BUILD/corpus/$target" log="$BUILD/$target.log"
  mkdir -p "$corpus" "$ROOT/tests/fuzz/corpus/$target"
  finding=none
  # With sanitizers, libsdformat takes 15 ms for a robot of seven links, and 4 ms for a hinge.
  limit=() length=8192
  [ "$target" != sdf ] || length=1024
  if [ "$seconds" -gt 0 ]; then limit=("-max_total_time=$seconds"); fi
  # Each input has 25 s of processor time (tests/fuzz/time_limit.h). The wall-clock limit is for one that waits for ever.
  # Without -entropic=0 a third of a quick target's time goes into choosing the next input.
  "$BUILD/fuzz/fuzz_$target" -runs="$runs" "${limit[@]}" -seed="$seed" -max_len="$length" -timeout=900 -entropic=0 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="$BUILD/findings/$target-" "$corpus" "$ROOT/tests/fuzz/corpus/$target" > "$log" 2>&1 || { finding="see $log"; failed=1; }
  printf '| %s | %s | %s | %s | %s |\n' "$target" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")" \
    "$(sed -n 's/^Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$log")" "$(ls "$corpus" | wc -l)" "$finding"
done
exit $failed
