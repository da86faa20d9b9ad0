#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/diagnose.sh [EXPERIMENT.yaml] [--out DIR] [options]
#
# Finds what a simulation left out. Installs what is missing, builds the tool, compares the experiment's recordings with
# its model, and writes DIR/report.html (logs/diagnosis/NAME when no folder is named). Without an experiment it runs on
# models/experiments/arm, in which something is hidden, and says where the answer is.
#
#   --resimulate servers|process   also runs the nominal and the updated scenario, through the server set or in one
#                                  process, and compares both with a recording that nothing was fitted to
#   --resimulate mujoco            the same two models on MuJoCo: DIR/updated/export/mujoco.yaml, as far as MJCF holds it
#   --controller PROGRAM           with --resimulate servers: closes the loop with the controller that walked, instead of
#                                  the recorded commands. PROGRAM joins over DDS: 'my-controller --option', with
#                                  `--domain N` added or N in the place of {domain}; hrp-controller, ours, by the section
#                                  `controller:` of the experiment; SCENARIO.yaml: ours, by that scenario's settings
#   --wait S                       seconds without an answer after which that controller counts as silent (30)
#   --next                         also proposes motions that would tell what is still open: DIR/next/*.csv, next.html
#   --rounds N --against REALITY   plays N rounds of such motions unattended: diagnose, propose, play, add the recordings,
#                                  diagnose again. REALITY is a SCENARIO.yaml with something in its effects (in-process
#                                  simulator), or a program that is called as PROGRAM COMMANDS.csv RECORDING.csv
#   --check                        only looks at the recordings: rates, gaps, clocks, motion, and what it can tell
# All other options go to hrp-diagnose, such as --jobs N, --patience F, --quiet.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

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
case "$previous" in --out | --resimulate | --controller | --wait | --rounds | --against) fail "$previous needs a value; --help says which" ;; esac
case "$again" in
  "" | servers | process | mujoco) ;;
  *) say "diagnose.sh: --resimulate wants 'servers', 'process' or 'mujoco', not '$again'"; exit 2 ;;
esac
if [ -n "$controller" ] && [ "$again" != servers ]; then
  say "diagnose.sh: --controller needs --resimulate servers: it joins the server set over DDS"; exit 2
fi
if [ -n "$rounds$against" ] && { [ -z "$rounds" ] || [ -z "$against" ]; }; then
  say "diagnose.sh: --rounds and --against belong together: how many rounds, and what plays the motions"; exit 2
fi
: "${experiment:=$ROOT/models/experiments/arm/experiment.yaml}"
[ -f "$experiment" ] || { say "diagnose.sh: no file $experiment"; exit 2; }
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
