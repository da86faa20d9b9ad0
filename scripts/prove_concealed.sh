#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/prove_concealed.sh [--cases N] [--seed S] [--jobs J] [--out DIR] [--family F | --effect E] [--stage STAGE] ...
#
# The blind trial of hrp-diagnose. Prints tables and writes DIR/proof.html. Stages:
#   make    a separate program simulates N cases with hidden physics on MuJoCo. The truths go into a sealed archive, and
#           the script prints its SHA-256
#   answer  the tool answers every case. The script prints a hash of the answers
#   open    the script opens the archive and counts
# Options (defaults in parentheses):
#   --cases N    number of cases (60)
#   --seed S     the same seed gives the same cases (seconds of the clock; printed)
#   --jobs J     tools that run at the same time (all cores)
#   --out DIR    working folder (out/proof-SEED)
#   --family F   only these families, a comma list such as stand,pair (hrp-make-cases --help lists them). dirty: robots
#                with friction and a rotor in every joint, as real ones
#   --effect E   only this effect
#   --urdf F     robot of all cases (random robots)
#   --sensors S  sensors of arms behind their gears, a comma list: joint_torque, link_encoder, imu, wrench
#   --limit T    seconds after which a run counts as no answer (600)
#   --cluster A  answers on a Dask cluster, as scripts/sweep.sh: "local", or the address of its scheduler
#   --duration D seconds of the longest recordings (10)
#   --stage X    make, answer (continues where it was stopped), open, or all (all)
#   --readme F   also rewrites the proof's block in this file (docs/diagnosis_proof.md)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

cases=60 seed="" jobs=$(nproc) out="" effect="" family="" urdf="" sensors="" limit=600 duration=10 stage=all readme="" cluster=""
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --cases | --seed | --jobs | --out | --effect | --family | --sensors | --urdf | --limit | --duration | --stage | --readme | --cluster)
      [ $# -ge 2 ] || { echo "prove_concealed.sh: $1 wants a value" >&2; exit 2; }
      declare "${1#--}=$2"; shift 2 ;;
    *) echo "prove_concealed.sh: unknown option $1" >&2; exit 2 ;;
  esac
done
case "$stage" in make | answer | open | all) ;; *) echo "prove_concealed.sh: no stage is called $stage" >&2; exit 2 ;; esac
if [ "$stage" = answer ] || [ "$stage" = open ]; then
  [ -n "$out" ] && [ -f "$out/trial.txt" ] || { echo "prove_concealed.sh: --stage $stage wants --out DIR of a trial made before" >&2; exit 2; }
fi
seed=${seed:-$(date +%s)}
out=${out:-$ROOT/out/proof-$seed}
[ -x "$BUILD/bin/hrp-make-cases" ] && [ -x "$BUILD/bin/hrp-diagnose" ] ||
  "$ROOT/scripts/build.sh" hrp-make-cases hrp-diagnose >&2

# 1. Cases, and the truths sealed: a plain archive with nothing in it that depends on the hour, so the hash is the seal.
make_cases() {
  if [ -e "$out/cases" ] || [ -e "$out/answers" ]; then
    echo "prove_concealed.sh: $out already holds a trial; name another folder with --out" >&2
    exit 2
  fi
  mkdir -p "$out"
  "$BUILD/bin/hrp-make-cases" --out "$out" --cases "$cases" --seed "$seed" --jobs "$jobs" --duration "$duration" \
    --models "$ROOT/models" \
    ${effect:+--effect "$effect"} ${family:+--family "$family"} ${urdf:+--urdf "$urdf"} ${sensors:+--sensors "$sensors"} ||
    [ $? -eq 1 ]  # a case could not be made, with any seed: the trial goes on without it
  local made
  made=$(find "$out/truths" -name '*.json' | wc -l)
  [ "$made" -gt 0 ] || { echo "prove_concealed.sh: no case could be made" >&2; exit 1; }
  tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -C "$out" -cf "$out/truths.sealed.tar" truths
  rm -r "$out/truths"
  sha256sum "$out/truths.sealed.tar" | cut -d' ' -f1 >"$out/seal.txt"
  echo "seed $seed, $made of $cases cases made${effect:+, only $effect}${family:+, only $family}${sensors:+, sensors $sensors}${urdf:+, robot $(basename "$urdf")}" >"$out/trial.txt"
}

# 2. The tool answers, with the workers of a sweep: a case that has its answer is not asked again, one whose process was
# killed is.
answer_all() {
  mkdir -p "$out/answers"
  /usr/bin/python3 "$ROOT/scripts/sweep/answers.py" --bin "$BUILD/bin" --out "$out" --jobs "$jobs" --limit "$limit" \
    ${cluster:+--cluster "$cluster"}
  (cd "$out/answers" && find . -name report.json -print0 | sort -z | xargs -0 -r sha256sum | sha256sum | cut -d' ' -f1) \
    >"$out/commitment.txt"
}

# 3. Only now the truths.
open_truths() {
  [ "$(sha256sum "$out/truths.sealed.tar" | cut -d' ' -f1)" = "$(cat "$out/seal.txt")" ] ||
    { echo "the sealed archive changed" >&2; exit 1; }
  tar -C "$out" -xf "$out/truths.sealed.tar"
  python3 "$ROOT/diagnosis/generator/score_cases.py" --truths "$out/truths" --answers "$out/answers" \
    --html "$out/proof.html" --json "$out/proof.json" ${readme:+--readme "$readme"} --note "$(cat "$out/trial.txt")" \
    --note "truths sealed: SHA-256 $(cat "$out/seal.txt")" \
    --note "answers committed: SHA-256 $(cat "$out/commitment.txt")" | tee "$out/proof.txt"
  echo
  echo "the same as a page: $out/proof.html"
}

if [ "$stage" = make ] || [ "$stage" = all ]; then
  make_cases
  echo "$(cat "$out/trial.txt"); truths sealed, SHA-256 $(cat "$out/seal.txt")"
fi
if [ "$stage" = answer ] || [ "$stage" = all ]; then
  answer_all
  echo "answers committed, SHA-256 of their list $(cat "$out/commitment.txt")"
fi
if [ "$stage" = open ] || [ "$stage" = all ]; then open_truths; fi
