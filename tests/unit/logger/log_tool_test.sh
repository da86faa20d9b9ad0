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

# No tool writes over what it reads, or over any log that it was not told to.
refused() {  # refused REASON COMMAND...: fails, says REASON, leaves one.mcap and two.mcap as they are
  if "${@:2}" > said.txt 2>&1; then claim "${*:2}: expected to fail"; fi
  grep -q -- "$1" said.txt || claim "${*:2}: expected '$1', got: $(cat said.txt)"
  [ "$(sha256sum one.mcap two.mcap)" = "$whole" ] || claim "${*:2} has destroyed a log"
}
whole="$(sha256sum one.mcap two.mcap)"
ln -s one.mcap link.mcap
for out in one.mcap ./link.mcap; do
  refused 'is the log that is read' "$hrp_log" recover one.mcap "$out"
  refused 'is the log that is read' "$hrp_log" recover one.mcap "$out" --force
  refused 'is the log that is read' "$hrp_log" csv one.mcap --out "$out" --force
  refused 'is the log that is read' "$hrp_log" plot one.mcap --out "$out"
  refused 'is the log that is read' "$hrp_log" pictures one.mcap --out "$out"
done
refused 'is a log; .*--force' "$hrp_log" recover one.mcap two.mcap
refused 'is a log; .*--force' "$hrp_log" csv one.mcap --out two.mcap
cp two.mcap three.mcap
"$hrp_log" recover cut.mcap three.mcap --force > /dev/null || claim "--force overwrites"
"$hrp_log" compare whole.mcap three.mcap > /dev/null || claim "a forced recovery is the same recovery"

# Nothing recovered is no success, and leaves nothing behind.
head -c 200 one.mcap > start.mcap
: > empty.mcap
refused 'nothing can be recovered' "$hrp_log" recover start.mcap nothing.mcap
refused 'is empty' "$hrp_log" recover empty.mcap nothing.mcap
refused 'no MCAP file' "$hrp_log" recover one.csv nothing.mcap
[ ! -e nothing.mcap ] || claim "a recovery of nothing leaves no file"

# A log of something else has no pushes and no pictures; damage is said whatever is asked.
refused 'no topic .hrp/robot_state.; it has: none' "$hrp_log" pushes start.mcap
refused 'no log of a simulation' "$hrp_log" pictures start.mcap --out nothing.svg
refused 'cut.mcap: offset' "$hrp_log" pushes cut.mcap

# The state's hash is spelled in one way: 16 hexadecimal digits.
hash="$("$hrp_log" hash one.mcap | sed -n 's/^state hash \([0-9a-f]\{16\}\) at step .*/\1/p')"
[ -n "$hash" ] || claim "hash prints the state's hash in hexadecimal digits"
"$hrp_log" cat one.mcap robot_state --field hash | grep -q "^--- .*" || claim "cat prints"
"$hrp_log" cat one.mcap robot_state --field hash | tail -n 1 | grep -qx "$hash" || claim "cat spells the hash as hash does"
"$hrp_log" cat one.mcap robot_state --field hash --json | tail -n 1 | grep -q "\"message\":\"$hash\"" || claim "and so does JSON"
echo "all claims hold"
