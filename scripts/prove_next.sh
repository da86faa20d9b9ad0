#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/prove_next.sh [--cases N] [--seed S] [--jobs J] [--out DIR] [--family F] [--poor T] [--seconds T] [--stage STAGE]
#
# The trial of hrp-diagnose --next. Prints the table and writes DIR/next.json.
#
# Another engine makes N cases with poor first recordings: short, slow, small, one joint still. A case is open if the
# answer is wrong or leaves more than one explanation. An open case gets one round of the motions that the tool proposes.
# For comparison, it gets one round of multisines of the same length instead. Robot, hidden physics and noise are the same.
# Options (defaults in parentheses):
#   --cases N    number of cases (20)
#   --seed S     the same seed gives the same cases (seconds of the clock; printed)
#   --jobs J     tools that run at the same time (all cores)
#   --out DIR    working folder (out/next-SEED); a stopped trial continues there
#   --family F   families of hrp-make-cases, a comma list (joint,link,pair,pair_same_joint). arm_dirty: friction and rotors
#                in every joint; stand_joint,stand_link,stand_foot,stand_pair: standing robots; walk: walks with one or two
#                effects or none; walk_dirty: with friction and rotors in every joint. Motions on the feet follow two short
#                walks
#   --poor T     seconds of the first recordings (2); of walks at least 3, a single step
#   --seconds T  seconds of a proposed motion (6)
#   --limit T    seconds after which a run counts as no answer (900)
#   --stage X    table: only counts existing answers; all (all)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

cases=20 seed="" jobs=$(nproc) out="" family=joint,link,pair,pair_same_joint poor=2 seconds=6 limit=900 stage=all
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --cases | --seed | --jobs | --out | --family | --poor | --seconds | --limit | --stage)
      [ $# -ge 2 ] || { echo "prove_next.sh: $1 wants a value" >&2; exit 2; }
      declare "${1#--}=$2"; shift 2 ;;
    *) echo "prove_next.sh: unknown option $1" >&2; exit 2 ;;
  esac
done
case "$stage" in table | all) ;; *) echo "prove_next.sh: no stage is called $stage" >&2; exit 2 ;; esac
seed=${seed:-$(date +%s)}
out=${out:-$ROOT/out/next-$seed}
[ -x "$BUILD/bin/hrp-make-cases" ] && [ -x "$BUILD/bin/hrp-diagnose" ] ||
  "$ROOT/scripts/build.sh" hrp-make-cases hrp-diagnose >&2

make_cases() { # FOLDER NAME (empty: all) [options]
  [ -d "$1/cases/$2" ] || "$BUILD/bin/hrp-make-cases" --out "$1" --cases "$cases" --seed "$seed" --family "$family" \
    --poor "$poor" --only "$2" "${@:3}"
}

answer_in() { answer "$1/answers/$2" "$1/cases/$2/experiment.yaml" "$limit" --jobs 1 "${@:3}"; } # FOLDER NAME [options]
score() { python3 "$ROOT/diagnosis/generator/score_next.py" "$out" "$@"; }

answer_case() { # NAME: first recordings; where these leave something open, one round of each kind
  answer_in "$out/first" "$1" --next --seconds "$seconds"
  score --open | grep -qx "$1" || return 0
  make_cases "$out/proposed" "$1" --play "$out/first/answers"
  make_cases "$out/multisines" "$1" --play "$out/first/answers" --multisines
  # A motion that the hidden robot could not play leaves no experiment: no answer.
  for kind in proposed multisines; do answer_in "$out/$kind" "$1"; done
}

if [ "$stage" != table ]; then
  # A hidden robot that cannot play the poor motion either is no case: the others go on.
  make_cases "$out/first" "" || echo "some cases could not be made" >&2
  echo "seed $seed, $cases cases of $family, first recordings of $poor s, motions of $seconds s"
  export ROOT BUILD out cases seed family poor seconds limit
  export -f make_cases answer answer_in say score answer_case
  ls "$out/first/cases" | xargs -P "$jobs" -I{} bash -c 'answer_case "$@"' _ {}
fi
score
