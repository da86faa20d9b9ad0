#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/sweep.sh SWEEP.yaml [--out DIR] [--jobs N] [--cluster ADDRESS|local] [--limit S]
#
# Runs every combination of the scenarios, robots, controllers, parameters and seeds in a file (docs/tutorials/sweep.md),
# without bus and log. Writes DIR/table.csv and DIR/report.html (default DIR: logs/NAME). The same command continues a
# sweep that was stopped or killed.
#   --jobs N            runs at the same time (default: number of available cores)
#   --cluster ADDRESS   runs on the workers of a Dask scheduler (Debian's python3-distributed); local: starts a cluster on
#                       the cores of this machine
#   --limit S           time limit of one run in seconds (default 600)
# Example: scripts/sweep.sh models/sweeps/friction_and_slope.yaml --out swept
# Exit status: 0 all runs were done, 1 a run could not be done, 2 the file, an option or a folder cannot be used.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$ROOT/scripts/build.sh" --run hrp-trial >&2
# Debian's own interpreter: another one before it in the path knows nothing of Debian's packages.
exec /usr/bin/python3 "$ROOT/scripts/sweep/main.py" --bin "$BUILD/bin" "$@"
