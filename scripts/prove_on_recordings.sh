#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/prove_on_recordings.sh [--number N] [--seed S] [--jobs J] [--out DIR] [EXPERIMENT.yaml ...]
#
# Adds one known effect to recordings of yours and asks hrp-diagnose for it. You see whether the tool would find such an effect
# in your machine, beside all that the machine has by itself. Prints a table and writes DIR/hidden.json.
#
# Without files: the six machines with a fixed base in ../shared/recordings, if they are there. The recordings must be CSV, with
# efforts, or commands of a servo with stated gains.
# Options (defaults in parentheses):
#   --number N   cases from each experiment (8)
#   --seed S     the same seed adds the same effects (seconds of the clock; printed)
#   --jobs J     tools that run at the same time (all cores)
#   --out DIR    working folder (out/hidden-SEED); a stopped trial continues there
#   --limit T    seconds after which a run counts as no answer (900)
#   --stage X    table: only counts existing answers; all (all)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

number=8 seed="" jobs=$(nproc) out="" limit=900 stage=all experiments=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --number | --seed | --jobs | --out | --limit | --stage)
      [ $# -ge 2 ] || refuse "$1 wants a value"
      declare "${1#--}=$2"; shift 2 ;;
    -*) refuse "unknown option $1; --help lists the known ones" ;;
    *) [ -f "$1" ] || refuse "there is no file $1"; experiments+=("$1"); shift ;;
  esac
done
case "$stage" in table | all) ;; *) refuse "no stage is called $stage" ;; esac
if [ ${#experiments[@]} -eq 0 ]; then
  for name in bam_xl330_kp100 bam_xl330_kp400 dfki_double_pendulum dfki_simple_pendulum go2_hanging sydney_hip; do
    [ ! -f "$ROOT/../shared/recordings/$name/experiment.yaml" ] || experiments+=("$ROOT/../shared/recordings/$name/experiment.yaml")
  done
  [ ${#experiments[@]} -gt 0 ] || refuse "no experiment named, and ../shared/recordings is not there"
fi
seed=${seed:-$(date +%s)}
out=${out:-$ROOT/out/hidden-$seed}
[ -x "$BUILD/bin/hrp-diagnose" ] || "$ROOT/scripts/build.sh" hrp-diagnose >&2

export -f answer say
export BUILD out limit

if [ "$stage" != table ]; then
  echo "seed $seed, $number cases from each of ${#experiments[@]} experiments"
  list=()
  for experiment in "${experiments[@]}"; do
    /usr/bin/python3 "$ROOT/diagnosis/generator/hide_in_recordings.py" "$experiment" "$out/cases" --number "$number" --seed "$seed"
    list+=("$(basename "$(dirname "$(realpath "$experiment")")")" "$(realpath "$experiment")")
  done
  for folder in "$out"/cases/*/; do list+=("$(basename "$folder")" "$(realpath "$folder")/experiment.yaml"); done
  printf '%s\n' "${list[@]}" | xargs -d '\n' -P "$jobs" -n 2 bash -c 'answer "$out/answers/$1" "$2" "$limit" --jobs 1 --quiet' _
fi
python3 "$ROOT/diagnosis/generator/score_hidden.py" "$out"
