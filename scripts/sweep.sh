#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/sweep.sh SWEEP.yaml [--out DIR] [--jobs N] [--cluster ADDRESS|local] [--limit S]
#
# Runs a scenario many times: every combination of scenarios, robots, controllers, parameters and seeds that the file names
# (docs/tutorials/sweep.md), without bus and log. Writes DIR/table.csv and DIR/report.html (default logs/NAME). A sweep that
# was stopped or killed goes on with the same command.
#   --jobs N            runs at a time (default: as many as cores that it may use)
#   --cluster ADDRESS   on the workers of a Dask scheduler (Debian's python3-distributed); local: one of this machine's cores
#   --limit S           seconds that one run may take (default 600)
# Exit status 1 when a run could not be done.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$ROOT/scripts/build.sh" --run hrp-trial >&2
# Debian's own interpreter: another one before it in the path knows nothing of Debian's packages.
exec /usr/bin/python3 "$ROOT/scripts/sweep/main.py" --bin "$BUILD/bin" "$@"
