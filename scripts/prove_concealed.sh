#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/prove_concealed.sh [--cases N] [--seed S] [--jobs J] [--out DIR] [--effect NAME] [--limit SECONDS]
#
# The blind trial of hrp-diagnose. A separate program makes N cases with MuJoCo as reality and hides physics in them; the
# truths go into a sealed archive whose SHA-256 is printed before the tool sees a case; the tool answers all; its answers
# are hashed too; only then is the archive opened and everything counted. Prints the tables and writes DIR/proof.html.
#   --cases N    how many (60)               --seed S   the same seed gives the same cases (the clock's second, printed)
#   --jobs J     tools at a time (all cores) --out DIR  where to work (out/proof-SEED)
#   --effect E   only this effect            --limit T  seconds after which a run counts as no answer (600)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

cases=60 seed=$(date +%s) jobs=$(nproc) out="" effect="" limit=600
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --cases) cases=$2; shift 2 ;;
    --seed) seed=$2; shift 2 ;;
    --jobs) jobs=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    --effect) effect=$2; shift 2 ;;
    --limit) limit=$2; shift 2 ;;
    *) echo "prove_concealed.sh: unknown option $1" >&2; exit 2 ;;
  esac
done
out=${out:-$ROOT/out/proof-$seed}
if [ -e "$out/cases" ] || [ -e "$out/answers" ]; then
  echo "prove_concealed.sh: $out already holds a trial; name another folder with --out" >&2
  exit 2
fi
if [ ! -x "$BUILD/bin/hrp-make-cases" ] || [ ! -x "$BUILD/bin/hrp-diagnose" ]; then
  "$ROOT/scripts/install_deps.sh"
  "$ROOT/scripts/build.sh" >&2
fi

# 1. Cases, and the truths sealed: a plain archive with nothing in it that depends on the hour, so the hash is the seal.
mkdir -p "$out"
"$BUILD/bin/hrp-make-cases" --out "$out" --cases "$cases" --seed "$seed" --jobs "$jobs" ${effect:+--effect "$effect"}
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -C "$out" -cf "$out/truths.sealed.tar" truths
rm -r "$out/truths"
seal=$(sha256sum "$out/truths.sealed.tar" | cut -d' ' -f1)
echo "seed $seed, $cases cases; truths sealed, SHA-256 $seal"

# 2. The tool answers. It gets a folder that holds the case alone.
answer() {
  local folder=$1 answer="$2/answers/$(basename "$1")" begin end status=0
  mkdir -p "$answer"
  begin=$(date +%s.%N)
  timeout "$4" "$3" "$folder/experiment.yaml" --out "$answer" --jobs 1 >"$answer/terminal.txt" 2>&1 || status=$?
  end=$(date +%s.%N)
  printf '{"status": %d, "seconds": %.1f}\n' "$status" "$(awk "BEGIN {print $end - $begin}")" >"$answer/run.json"
  printf '%s: status %d, %.0f s\n' "$(basename "$folder")" "$status" "$(awk "BEGIN {print $end - $begin}")"
}
export -f answer
find "$out/cases" -mindepth 1 -maxdepth 1 -type d -print0 | sort -z |
  xargs -0 -P "$jobs" -I{} bash -c 'answer "$@"' _ {} "$out" "$BUILD/bin/hrp-diagnose" "$limit"
commitment=$(cd "$out/answers" && find . -name report.json -print0 | sort -z | xargs -0 -r sha256sum | sha256sum | cut -d' ' -f1)
echo "answers committed, SHA-256 of their list $commitment"

# 3. Only now the truths.
[ "$(sha256sum "$out/truths.sealed.tar" | cut -d' ' -f1)" = "$seal" ] || { echo "the sealed archive changed" >&2; exit 1; }
tar -C "$out" -xf "$out/truths.sealed.tar"
python3 "$ROOT/diagnosis/generator/score_cases.py" --truths "$out/truths" --answers "$out/answers" \
  --html "$out/proof.html" --json "$out/proof.json" --note "seed $seed, $cases cases${effect:+, only $effect}" \
  --note "truths sealed: SHA-256 $seal" --note "answers committed: SHA-256 $commitment" | tee "$out/proof.txt"
echo
echo "the same as a page: $out/proof.html"
