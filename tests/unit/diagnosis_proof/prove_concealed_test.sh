#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# prove_concealed_test.sh SOURCE_DIR BUILD_DIR: the blind trial from end to end on two short cases: the seal is printed
# before the first answer and holds, a trial that was stopped goes on, tampered truths are refused, the block of tables in a
# document is rewritten and nothing else of it.
set -euo pipefail
source_dir="$1"
export HRP_BUILD_DIR="$2"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
claim() { echo "failed: $1" >&2; exit 1; }
prove() { "$source_dir/scripts/prove_concealed.sh" "$@"; }

prove --cases 2 --seed 13 --family none --duration 1 --jobs 1 --out "$folder/p" --stage make > "$folder/make.txt" 2>&1
seal="$(sha256sum "$folder/p/truths.sealed.tar" | cut -d' ' -f1)"
grep -q "SHA-256 $seal" "$folder/make.txt" || claim "the seal is printed"
[ ! -e "$folder/p/truths" ] || claim "no truth lies open while the tool answers"
[ -z "$(grep -rl hidden "$folder/p/cases")" ] || claim "a case says nothing of what is hidden"

mkdir -p "$folder/p/answers/case-001"
echo '{"status": 0, "seconds": 0.1}' > "$folder/p/answers/case-001/run.json"   # as if it had been stopped here
prove --out "$folder/p" --stage answer --jobs 1 > "$folder/answer.txt" &
killed=""
while [ -z "$killed" ] && kill -0 $! 2>/dev/null; do
  killed="$(pgrep -f "hrp-diagnose $folder/p/cases/case-002" || true)"
done
[ -z "$killed" ] || kill -9 $killed   # that answer is nothing; it is asked for again
wait $!
[ -n "$killed" ] || claim "the tool was killed in mid-answer"
grep -q '^2 cases, 1 answered before' "$folder/answer.txt" || claim "what is done is known"
grep -q '^\[1/1\] .* left' "$folder/answer.txt" || claim "progress is shown, and what remains"
grep -q '"status": 0' "$folder/p/answers/case-002/run.json" || claim "a killed tool is asked again"
[ ! -e "$folder/p/answers/case-001/report.json" ] || claim "an answered case is not asked again"
[ -e "$folder/p/answers/case-002/report.json" ] || claim "the other one is"

printf 'before, with the marks `<!-- proof: begin` and `<!-- proof: end -->`\n<!-- proof: begin -->\nold\n<!-- proof: end -->\nafter\n' > "$folder/readme.md"
prove --out "$folder/p" --stage open --readme "$folder/readme.md" > "$folder/open.txt"
grep -q 'runs without an answer *1 of 2' "$folder/open.txt" || claim "a case without an answer is counted"
head -n 1 "$folder/readme.md" | grep -q '^before' && tail -n 1 "$folder/readme.md" | grep -q '^after' || claim "the rest of the document stays"
grep -q "SHA-256 $seal" "$folder/readme.md" || claim "the block names the seal"
grep -q '<svg' "$folder/p/proof.html" || claim "the page has pictures"

echo x >> "$folder/p/truths.sealed.tar"
if prove --out "$folder/p" --stage open > /dev/null 2>&1; then claim "tampered truths are refused"; fi
echo "all claims hold"
