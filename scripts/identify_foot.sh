#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Identifies the rubber in the feet (Mikami et al. 2014) and writes a report.
#
#   identify_foot.sh [SCENARIO.yaml] [--out DIR] [--in-process]
#       Makes motions for the robot (default: models/scenarios/paper_b/foot.yaml), checks them, simulates each with the
#       server set, and identifies the rubber.
#       --in-process: without servers, a few times faster, the same numbers.
#       --rubber hardening | hysteresis: simulates rubber that hardens, or has hysteresis, instead of the scenario's
#       linear one. The report says whether the fit detects this.
#       --motions rich | paper: our 18 motions (default), or the 14 of the paper: its five sways for the fit, the others
#       for validation.
#       --improve N: adds motions for the least known parameters, as `diagnose.sh --next` does; tries N of each family.
#   identify_foot.sh --coverage N [SCENARIO.yaml] [--out DIR]
#       Counts how often the 95 % intervals contain the truth, over N seeds of the sensor noise, in process. Prints a
#       table.
#   identify_foot.sh EXPERIMENT.yaml --out DIR
#       Identifies from recordings of a robot: an experiment with the key `recordings` (docs/identification.md).
#
# Results: DIR/report.html, and DIR/identified.yaml, which scripts/simulate.sh runs.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
bin="$BUILD/bin"
scenario="$ROOT/models/scenarios/paper_b/foot.yaml"
out="" in_process="" coverage="" improve=0 rubber=given motions=rich
while [ $# -gt 0 ]; do
  case "$1" in
    --out) [ $# -ge 2 ] || refuse "--out needs a folder"; out=$2; shift ;;
    --in-process) in_process=yes ;;
    --coverage) [ $# -ge 2 ] || refuse "--coverage needs a number of seeds"; coverage=$2; shift ;;
    --rubber) [ $# -ge 2 ] || refuse "--rubber needs hardening or hysteresis"; rubber=$2; shift ;;
    --motions) [ $# -ge 2 ] || refuse "--motions needs rich or paper"; motions=$2; shift ;;
    --improve) [ $# -ge 2 ] || refuse "--improve needs a number of tries"; improve=$2; shift ;;
    -*) refuse "unknown option $1" ;;
    *) scenario=$1 ;;
  esac
  shift
done
: "${out:=identify_foot}"
[ -x "$bin/hrp-identify-foot" ] && [ -x "$bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" --run hrp-identify-foot >&2
[ -f "$scenario" ] || refuse "no file $scenario"
if grep -q '^recordings:' "$scenario"; then
  exec "$bin/hrp-identify-foot" experiment "$scenario" --out "$out"
fi
mkdir -p "$out/runs"
# Exit status 1: some motion was refused; the others are used.
"$bin/hrp-identify-foot" make "$scenario" "$out/runs" --improve "$improve" --rubber "$rubber" --motions "$motions" || { status=$?; [ $status -eq 1 ] || exit $status; }
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
