#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# log_tool_test.sh MAKE_LOG HRP_LOG: what hrp-log says of whole, damaged and different logs.
set -euo pipefail
make_log="$1" hrp_log="$2"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
claim() { echo "failed: $1" >&2; exit 1; }

"$make_log" one.mcap zstd
"$make_log" two.mcap none
"$hrp_log" compare one.mcap two.mcap | grep -q '^equal: 242 messages' || claim "equal messages are equal, however compressed"
[ "$("$hrp_log" hash one.mcap)" = "$("$hrp_log" hash two.mcap)" ] || claim "equal messages have equal hashes"
"$hrp_log" info one.mcap | grep -q 'closed and indexed' || claim "a whole log is said to be whole"

# Cut within the last chunk: said, readable up to there, and made whole again.
head -c "$(($(stat -c %s one.mcap) * 6 / 10))" one.mcap > cut.mcap
if "$hrp_log" info cut.mcap > cut.txt 2> damage.txt; then claim "damage gives status 1"; fi
grep -q 'cut.mcap: offset' damage.txt || claim "damage is named with its offset"
"$hrp_log" recover cut.mcap whole.mcap | grep -q 'left behind' || claim "recover says what it leaves behind"
"$hrp_log" info whole.mcap > /dev/null || claim "a recovered log is whole"
if "$hrp_log" compare one.mcap whole.mcap > difference.txt; then claim "a shorter log differs"; fi
grep -q 'equal as far as both go' difference.txt || claim "what was recovered is what was written"

[ "$("$hrp_log" cat one.mcap sensor_data --json | wc -l)" -eq 15 ] || claim "one line of JSON a message"
"$hrp_log" csv one.mcap --out one.csv > /dev/null
[ "$(wc -l < one.csv)" -eq 16 ] || claim "one row a sensor sample, and a header"
head -n 1 one.csv | grep -q '^time,/joint_commands/joint0/position,.*/wrench/l_foot/force/x' || claim "columns are named"
"$hrp_log" plot one.mcap --out one.svg --signal /joint_states/joint1/effort --signal robot_state:positions[0]
grep -q '</svg>' one.svg || claim "a plot is an SVG file"
if "$hrp_log" plot one.mcap --out no.svg --signal /joint_states/joint1/efort 2> wrong.txt; then claim "unknown signals fail"; fi
grep -q "did you mean '/joint_states/joint1/effort'" wrong.txt || claim "the nearest signal is named"
echo "all claims hold"
