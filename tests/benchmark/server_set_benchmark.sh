#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# tests/benchmark/server_set_benchmark.sh [SECONDS] [ROUNDS]
#
# The whole server set, our HRP-2P-like robot standing on box soles at 1 kHz, logger on: real-time factor, start-up to
# the first step, memory. Six processes on Cyclone DDS and on Fast DDS, and all in one process, in turns, because
# machines drift. No pass or fail. Needs a build (scripts/build.sh).
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
source "$here/../../scripts/lib.sh"
case "${1:-}" in -h | --help) print_help; exit 0 ;; esac
seconds="${1:-10}"
rounds="${2:-3}"
scenario="$ROOT/models/scenarios/hrp2p_stand.yaml"
simulate="$BUILD/bin/hrp-simulate"
[ -x "$simulate" ] || fail "$simulate is not there; scripts/build.sh makes it"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT

# Sum of the proportional set sizes (shared pages counted once) of a process and its children [MB].
measure_memory() {
  local pid total=0 part
  for pid in "$1" $(pgrep -P "$1" || true); do
    part="$(awk '/^Pss:/ { print $2 }' "/proc/$pid/smaps_rollup" 2> /dev/null || true)"
    total=$((total + ${part:-0}))
  done
  echo $((total / 1024))
}

now() { date +%s%N; }

# run NAME OPTIONS...: one line of figures. The first step is seen as the first growth of the log beyond its header,
# which comes 32 steps later: an upper bound.
run() {
  local name="$1" log="$folder/run.mcap" begin first="" peak=0 memory
  shift
  rm -f "$log"
  begin="$(now)"
  "$simulate" "$scenario" --duration "$seconds" --log "$log" --quiet --no-plot "$@" > "$folder/out" 2>&1 &
  local pid=$!
  while kill -0 "$pid" 2> /dev/null; do
    if [ -z "$first" ] && [ "$(stat -c %s "$log" 2> /dev/null || echo 0)" -gt 32768 ]; then first="$(now)"; fi
    memory="$(measure_memory "$pid")"
    if [ "$memory" -gt "$peak" ]; then peak="$memory"; fi
    sleep 0.02
  done
  if ! wait "$pid"; then
    tail -n 5 "$folder/out"
    printf '%-12s failed\n' "$name"
    return
  fi
  local factor
  factor="$(sed -n 's/^simulated.*(\([0-9.]*\) x real time).*/\1/p' "$folder/out")"
  printf '%-12s %8s x real time   first chunk of the log after %5d ms   %4d MB\n' "$name" "$factor" \
    $(((${first:-$(now)} - begin) / 1000000)) "$peak"
}

echo "machine:  $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores, kernel $(uname -r)"
echo "command:  hrp-simulate models/scenarios/$(basename "$scenario") --duration $seconds --quiet --no-plot [...]"
for ((round = 1; round <= rounds; ++round)); do
  echo "round $round"
  run cyclone --dds cyclone
  run fast --dds fast
  run in-process --in-process
done
