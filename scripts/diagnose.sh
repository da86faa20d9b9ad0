#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/diagnose.sh [EXPERIMENT.yaml] [--out DIR] [options]
# scripts/diagnose.sh --draft ROBOT LOG... [--out EXPERIMENT.yaml] [--force]
#
# Finds the physics that a simulation leaves out. Installs missing packages, builds the tool, compares the recordings of
# the experiment with its model, and writes DIR/report.html (default DIR: logs/diagnosis/NAME). Without an experiment, it
# runs on models/experiments/arm, which has a hidden effect, and prints where the answer is.
#
#   --resimulate servers|process   also simulates the nominal and the updated scenario, with the server set or in one
#                                  process, and compares both with a held-out recording
#   --resimulate mujoco            the same on MuJoCo, with what MJCF can express: DIR/updated/export/mujoco.yaml
#   --controller PROGRAM           with --resimulate servers: closes the loop with this controller, instead of replaying
#                                  the recorded commands. PROGRAM is one of
#                                    'my-controller --option'   joins over DDS; gets `--domain N`, or N for {domain}
#                                    hrp-controller             ours, with the section `controller:` of the experiment
#                                    SCENARIO.yaml              ours, with the settings of that scenario
#   --wait S                       seconds without an answer after which that controller counts as silent (30)
#   --next                         also proposes motions that decide between the remaining explanations:
#                                  DIR/next/*.csv, next.html
#   --rounds N --against REALITY   runs N rounds without a person: diagnose, propose, play, add the recordings, diagnose
#                                  again. REALITY is a SCENARIO.yaml with `effects` (simulated in process), or a program
#                                  that is called as PROGRAM COMMANDS.csv RECORDING.csv
#   --draft ROBOT LOG...           writes a first experiment file for a robot's model and its logs, and says what is missing.
#                                  LOG: text, a bag of ROS 1 or 2, MCAP, NumPy (.npz, .npy), MATLAB (.mat), HDF5 (.h5), JSON
#   --check                        only checks the recordings: rates, gaps, clocks, motion, and which effects it can show
# All other options go to hrp-diagnose, such as --jobs N, --patience F, --quiet.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# Of NumPy, MATLAB, HDF5 and JSON it takes the text that is written beside the draft.
draft() {
  local words=() word previous="" folder=. force=() texts="|"
  for word in "$@"; do
    [ "$previous" != --out ] || folder="$(dirname "$word")"
    [ "$word" != --force ] || force=(--force)
    previous="$word"
  done
  for word in "$@"; do
    case "$word" in
      *.npz | *.npy | *.mat | *.h5 | *.hdf5 | *.json | *.jsonl)
        local name text number=1
        name="$(basename "${word%.*}")"
        text="$folder/$name.csv"
        while [[ "$texts" == *"|$text|"* ]]; do  # logs of one name in several folders
          number=$((number + 1))
          text="$folder/$name-$number.csv"
        done
        texts+="$text|"
        "$ROOT/scripts/diagnosis/to_text.py" "$word" --out "$text" "${force[@]}"
        words+=("$text")
        ;;
      *) words+=("$word") ;;
    esac
  done
  "$ROOT/scripts/build.sh" hrp-draft-experiment >&2
  exec "$BUILD/bin/hrp-draft-experiment" "${words[@]}"
}

if [ "${1:-}" = --draft ]; then draft "${@:2}"; fi
experiment="" out="" again="" previous="" controller="" patience=30 rounds="" against=""
options=()
for word in "$@"; do
  case "$previous" in
    --out) out="$word" ;;
    --resimulate) again="$word" ;;
    --controller) controller="$word" ;;
    --wait) patience="$word" ;;
    --rounds) rounds="$word" ;;
    --against) against="$word" ;;
    --limit) options+=("$word") ;;
    *)
      case "$word" in
        -h | --help) print_help; exit 0 ;;
        *.yaml | *.yml) experiment="$word" ;;
        --out | --resimulate | --controller | --wait | --rounds | --against) ;;
        *) [ -d "$word" ] && [ -z "$experiment" ] && [ -f "$word/experiment.yaml" ] && experiment="$word/experiment.yaml" || options+=("$word") ;;
      esac
      ;;
  esac
  case "$previous" in --out | --resimulate | --controller | --wait | --rounds | --against | --limit) previous="" ;; *) previous="$word" ;; esac
done
case "$previous" in --out | --resimulate | --controller | --wait | --rounds | --against) refuse "$previous needs a value; --help says which" ;; esac
case "$again" in
  "" | servers | process | mujoco) ;;
  *) refuse "--resimulate wants 'servers', 'process' or 'mujoco', not '$again'" ;;
esac
if [ -n "$controller" ] && [ "$again" != servers ]; then
  refuse "--controller needs --resimulate servers: it joins the server set over DDS"
fi
if [ -n "$rounds$against" ] && { [ -z "$rounds" ] || [ -z "$against" ]; }; then
  refuse "--rounds and --against belong together: how many rounds, and what plays the motions"
fi
if [ -n "$rounds" ]; then
  [[ "$rounds" =~ ^[1-9][0-9]{0,3}$ ]] || refuse "--rounds is '$rounds', expected a number from 1 to 9999"
  case "$against" in
    *.yaml | *.yml) [ -f "$against" ] || refuse "--against: no file $against" ;;
    *) command -v "${against%% *}" > /dev/null || refuse "--against: no program ${against%% *}, and no file SCENARIO.yaml" ;;
  esac
fi
[[ "$patience" =~ ^[0-9]+(\.[0-9]+)?$ ]] || refuse "--wait is '$patience', expected seconds"
: "${experiment:=$ROOT/models/experiments/arm/experiment.yaml}"
[ -f "$experiment" ] || refuse "no file $experiment"
folder="$(cd "$(dirname "$experiment")" && pwd)"
name="$(basename "$folder")"
: "${out:=$ROOT/logs/diagnosis/$name}"

targets=(hrp-diagnose)
[ -z "$rounds" ] || targets+=(hrp-simulate hrp-log)
case "$again" in servers) targets+=(hrp_run_programs hrp-log) ;; mujoco) targets+=(hrp_run_programs hrp-dynamics-mujoco hrp-log) ;; process) targets+=(hrp-simulate hrp-log) ;; esac
"$ROOT/scripts/build.sh" "${targets[@]}" >&2
case " ${options[*]} " in
  *" --check "*) exec "$BUILD/bin/hrp-diagnose" "$experiment" "${options[@]}" ;;
esac
if [ -n "$rounds" ]; then
  exec python3 "$ROOT/scripts/diagnosis/next_rounds.py" "$BUILD/bin" "$experiment" "$out" "$rounds" "$against" "${options[@]}"
fi
closed=()
if [ -n "$controller" ]; then
  closed=(--controller "$controller" --experiment "$experiment" --wait "$patience")
  # A controller that cannot be started is said now, not after the diagnosis.
  python3 "$ROOT/scripts/diagnosis/resimulate.py" "$BUILD/bin" "$out" servers "${closed[@]}" --only-check
fi
"$BUILD/bin/hrp-diagnose" "$experiment" --out "$out" "${options[@]}"
say "The report as a page: $out/report.html"
answer="$(dirname "$folder")/answers/$name.json"
[ ! -f "$answer" ] || say "What was hidden, to be read after the report: $answer"
[ -z "$again" ] || python3 "$ROOT/scripts/diagnosis/resimulate.py" "$BUILD/bin" "$out" "$again" "${closed[@]}"
