#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/simulate.sh [SCENARIO.yaml] [options]
#
# Installs what is missing, builds, and runs the server set on a scenario (models/scenarios/default.yaml when none is
# named). Ends with the place of the log, a plot of the contact forces and a summary. All options go to hrp-simulate:
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$ROOT/scripts/install_deps.sh"
"$ROOT/scripts/build.sh" >&2

scenario_given=false
for argument in "$@"; do
  case "$argument" in
    -h | --help) print_help; echo; exec "$BUILD/bin/hrp-simulate" --help ;;
    *.yaml | *.yml) scenario_given=true ;;
    --view)
      "$ROOT/scripts/install_deps.sh" --viewer
      "$ROOT/scripts/build_page.sh"
      ;;
  esac
done
$scenario_given || set -- "$ROOT/models/scenarios/default.yaml" "$@"
exec "$BUILD/bin/hrp-simulate" "$@"
