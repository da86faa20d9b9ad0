#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/experiments.sh [all|paper|beyond|fig3|fig4|...|NAME ...] [--dds both|cyclone|fast] [--out DIR] [--runs N]
#                        [--jobs N] [--list] [--walking]
#
# Runs the experiments of Hirukawa et al. 2003 with the server set, and compares each with its claim. Writes one
# self-contained page, DIR/report.html (default DIR: logs/experiments), and its table, DIR/table.md.
#
#   --dds both       (default) each run goes twice over Cyclone DDS and once over Fast DDS; all logs must be equal
#   --runs N         more runs of each, with small random changes of masses and pose (default 10, 0 = none)
#   --jobs N         experiments at the same time (default: number of cores)
#   story --walking  diagnoses a walk on soft soles with a model that has rigid feet and perfect joints, and simulates
#                    the walk of each found model
# Example: scripts/experiments.sh fig7 --runs 0 --dds cyclone
# Exit status 1 if a claim does not hold.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case " $* " in
  *" -h "* | *" --help "*) print_help; exit 0 ;;
esac
"$ROOT/scripts/build.sh" --run hrp-log hrp-plot hrp-trial hrp-diagnose >&2
exec python3 "$ROOT/scripts/experiments/main.py" --bin "$BUILD/bin" "$@"
