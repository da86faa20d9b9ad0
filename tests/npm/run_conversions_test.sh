#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# run_conversions_test.sh BIN SCENARIO: what hrp-log makes of a run for Foxglove and ROS 2, read by Foxglove's libraries.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
if [ ! -d "$here/node_modules" ]; then
  echo "tests/npm/node_modules is not there; tests/npm/install.sh fetches it (scripts/test.sh does so by itself)" >&2
  exit 1
fi
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
"$1/hrp-simulate" "$2" --in-process --duration 1 --quiet --no-plot --log "$folder/run.mcap" > /dev/null
"$1/hrp-log" foxglove "$folder/run.mcap" --out "$folder/foxglove.mcap"
"$1/hrp-log" rosbag "$folder/run.mcap" --out "$folder/bag"
node "$here/read_conversions.mjs" "$folder/foxglove.mcap" "$folder/bag/bag_0.mcap"
