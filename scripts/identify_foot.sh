#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Identifies the rubber in the feet (Mikami et al. 2014) and writes a report.
#
#   identify_foot.sh [SCENARIO.yaml] [--out DIR] [--in-process]
#       makes the motions for the robot (default: models/scenarios/paper_b/foot.yaml), checks them, runs each through
#       the server set, identifies. --in-process: without servers, a few times faster, the same numbers.
#       --rubber hardening | hysteresis: the robot gets rubber that hardens or remembers instead of the scenario's linear
#       one, to see whether that is found.
#       --motions rich | paper: our eighteen motions (default), or the fourteen of the paper: its five sways are fitted, the
#       others validate.
#       --improve N: adds motions that tell what is least known, from the machine of `diagnose.sh --next`; N of each
#       family are tried.
#   identify_foot.sh --coverage N [SCENARIO.yaml] [--out DIR]
#       how often the 95 % intervals hold the truth: N seeds of the sensors' noise, in process; a table.
#   identify_foot.sh EXPERIMENT.yaml --out DIR
#       the same from recordings of one's own: an experiment with the key `recordings` (docs/identification.md).
#
# Afterwards: DIR/report.html, and DIR/identified.yaml, which scripts/simulate.sh runs.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
bin="$BUILD/bin"
scenario="$ROOT/models/scenarios/paper_b/foot.yaml"
out="" in_process="" coverage="" improve=0 rubber=given motions=rich
while [ $# -gt 0 ]; do
  case "$1" in
    --out) [ $# -ge 2 ] || { echo "identify_foot.sh: --out needs a folder" >&2; exit 2; }; out=$2; shift ;;
    --in-process) in_process=yes ;;
    --coverage) [ $# -ge 2 ] || { echo "identify_foot.sh: --coverage needs a number of seeds" >&2; exit 2; }; coverage=$2; shift ;;
    --rubber) [ $# -ge 2 ] || { echo "identify_foot.sh: --rubber needs hardening or hysteresis" >&2; exit 2; }; rubber=$2; shift ;;
    --motions) [ $# -ge 2 ] || { echo "identify_foot.sh: --motions needs rich or paper" >&2; exit 2; }; motions=$2; shift ;;
    --improve) [ $# -ge 2 ] || { echo "identify_foot.sh: --improve needs a number of tries" >&2; exit 2; }; improve=$2; shift ;;
    -*) echo "identify_foot.sh: unknown option $1" >&2; exit 2 ;;
    *) scenario=$1 ;;
  esac
  shift
done
: "${out:=identify_foot}"
[ -x "$bin/hrp-identify-foot" ] && [ -x "$bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" --run hrp-identify-foot >&2
if [ ! -f "$scenario" ]; then
  echo "identify_foot.sh: no file $scenario" >&2
  exit 2
fi
if grep -q '^recordings:' "$scenario"; then
  exec "$bin/hrp-identify-foot" experiment "$scenario" --out "$out"
fi
mkdir -p "$out/runs"
# Exit status 1: some motion was refused; the others are used.
"$bin/hrp-identify-foot" make "$scenario" "$out/runs" --improve "$improve" --rubber "$rubber" --motions "$motions" || [ $? -eq 1 ]
scenario="$out/runs/robot.yaml"
if [ -n "$coverage" ]; then
  exec "$bin/hrp-identify-foot" coverage "$scenario" "$out/runs" --seeds "$coverage"
fi
if [ -n "$in_process" ]; then
  exec "$bin/hrp-identify-foot" fit "$scenario" "$out/runs" --out "$out" --in-process
fi
while read -r name _; do
  echo "server set: $name"
  "$bin/hrp-simulate" "$out/runs/$name.yaml" --log "$out/runs/$name.mcap" --force --quiet --no-plot > "$out/runs/$name.log" 2>&1 || {
    cat "$out/runs/$name.log" >&2
    exit 1
  }
done < "$out/runs/motions.txt"
exec "$bin/hrp-identify-foot" fit "$scenario" "$out/runs" --out "$out"
