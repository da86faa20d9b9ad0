#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/soak.sh [--steps N] [--dds cyclone|fast] [--out FILE.csv] [--every SECONDS]
#
# Runs the server set for a long time and measures its processes: memory, threads, open files, steps per second. At the
# end, it compares the last third with the middle third. Status 1 if memory grows by more than 2 %, or threads or files by
# one.
#
#   --steps N   steps of the run, default 10000000: most of an hour
#   --out FILE  CSV file with one row for each server and measurement
#   --every S   seconds between measurements, default 5
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
[ -x "$BUILD/bin/hrp-simulate" ] || "$ROOT/scripts/build.sh" >&2
exec python3 "$ROOT/scripts/robustness/soak.py" "$BUILD/bin" "$ROOT/models/scenarios/hrp2p_stand.yaml" "$@"
