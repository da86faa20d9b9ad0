#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/soak.sh [--steps N] [--dds cyclone|fast] [--out FILE.csv] [--every SECONDS]
#
# Lets the server set run for long and looks at its processes meanwhile: memory, threads, open files, steps a second. At
# the end it compares the last third with the middle third. Status 1 when memory grows by more than 2 %, or threads or
# files by one.
#
#   --steps N   default 10000000: most of an hour
#   --out FILE  a row for each server and look
#   --every S   default 5
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
[ -x "$BUILD/bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" >&2
exec python3 "$ROOT/scripts/robustness/soak.py" "$BUILD/bin" "$ROOT/models/scenarios/hrp2p_stand.yaml" "$@"
