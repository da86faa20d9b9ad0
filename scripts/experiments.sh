#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/experiments.sh [all|paper|beyond|fig3|fig4|...|NAME ...] [--dds both|cyclone|fast] [--out DIR] [--runs N]
#                        [--jobs N] [--list] [--walking]
#
# Runs the experiments of Hirukawa et al. 2003 through the server set and judges each against its claim. Writes one
# self-contained page, DIR/report.html (default logs/experiments), and its table, DIR/table.md. Each run goes twice
# through the server set on Cyclone DDS and once on Fast DDS (--dds both), and all logs must be equal. --runs N: that many
# runs with small random changes of masses and pose (default 10, 0 = none). --jobs N: experiments at a time (default: as
# many as there are cores). `story --walking`: the diagnosis of a walk on soft soles that starts from rigid feet and joints
# that follow perfectly, and the walks of the models that come of it. Exit status 1 when a claim does not hold.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case " $* " in
  *" -h "* | *" --help "*) print_help; exit 0 ;;
esac
"$ROOT/scripts/build.sh" --run hrp-log hrp-plot hrp-trial hrp-diagnose >&2
exec python3 "$ROOT/scripts/experiments/main.py" --bin "$BUILD/bin" "$@"
