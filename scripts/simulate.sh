#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/simulate.sh [SCENARIO.yaml] [options]
#
# Installs missing packages, builds what a run needs, and runs a scenario. The default scenario is
# models/scenarios/default.yaml: the HRP-2P-like robot walks. At the end, it prints where the log and a plot of the contact
# forces are, a summary, and the command that plays the log back. All options go to hrp-simulate:
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

scenario_given=false
view=false
targets=()
previous=""
for argument in "$@"; do
  case "$argument" in
    *.yaml | *.yml) scenario_given=true ;;
    --view) view=true targets+=(hrp-viewer) ;;
    -h | --help) print_help; echo; [ -x "$BUILD/bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" --run >&2; exec "$BUILD/bin/hrp-simulate" --help ;;
  esac
  # Another program in the place of a server: one of this tree is built, too.
  case "$previous=$argument" in
    --program=*=hrp-dynamics-mujoco) targets+=(hrp-dynamics-mujoco) ;;
    --controller=*python*) targets+=(hrp_python) ;;
    --controller=my-controller*) targets+=(my-controller) ;;
  esac
  previous="$argument"
done
"$ROOT/scripts/build.sh" --run "${targets[@]}" >&2
if $view; then
  "$ROOT/scripts/install_deps.sh" --viewer
  "$ROOT/scripts/build_page.sh"
fi
$scenario_given || set -- "$ROOT/models/scenarios/default.yaml" "$@"
# A controller in Python finds the package of this tree.
export PYTHONPATH="$BUILD/python${PYTHONPATH:+:$PYTHONPATH}"
export HRP_VIEW_COMMAND="${0%/*}/view.sh"
exec "$BUILD/bin/hrp-simulate" "$@"
