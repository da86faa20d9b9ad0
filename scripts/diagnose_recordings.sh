#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/diagnose_recordings.sh [--out DIR] [--jobs J] [FOLDER ...]
#
# Runs hrp-diagnose on folders of real recordings (default: all in ../shared/recordings), and prints tables. The tables
# compare its model on held-out recordings with
#   - the nominal model,
#   - plain least squares of friction and rotor inertia,
#   - what other programs would answer: friction models that are fitted to the positions,
#   - the model that the authors published (models/published/NAME.yaml), if any,
#   - the plain baseline of ../shared/baselines, if any.
# For the folders of ../shared/recordings, it also writes the tables between the marks in docs/recordings.md.
#   --out DIR   one folder of answers for each recording (out/recordings)
#   --jobs J    threads of the tool (all cores)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

out=$ROOT/out/recordings jobs=$(nproc) folders=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) print_help; exit 0 ;;
    --out) out=$2; shift 2 ;;
    --jobs) jobs=$2; shift 2 ;;
    -*) refuse "unknown option $1; --help lists the known ones" ;;
    *) folders+=("$1"); shift ;;
  esac
done
table_options=()
if [ ${#folders[@]} -eq 0 ]; then
  [ -d "$ROOT/../shared/recordings" ] || refuse "no folder named, and ../shared/recordings is not there"
  folders=("$ROOT"/../shared/recordings/*/)
  table_options=(--page "$ROOT/docs/recordings.md")
fi
[ -x "$BUILD/bin/hrp-diagnose" ] && [ -x "$BUILD/bin/hrp-diagnose-baseline" ] ||
  "$ROOT/scripts/build.sh" hrp-diagnose hrp-diagnose-baseline >&2

for folder in "${folders[@]}"; do
  name=$(basename "$folder")
  answer=$out/$name
  rm -rf "$answer"
  answer "$answer" "$folder/experiment.yaml" "${HRP_DIAGNOSE_LIMIT:-900}" --jobs "$jobs"
  models=()
  [ ! -f "$ROOT/models/published/$name.yaml" ] || models+=("published=$ROOT/models/published/$name.yaml")
  [ ! -f "$answer/updated/scenario.yaml" ] || models+=("tool=$answer/updated/scenario.yaml")
  "$BUILD/bin/hrp-diagnose-baseline" "$folder/experiment.yaml" "${models[@]}" >"$answer/baseline.json" 2>"$answer/baseline.txt" || true
  floor=$ROOT/../shared/baselines/torque_evidence.py
  [ ! -f "$floor" ] || /usr/bin/python3 "$floor" "$folder" >"$answer/floor.txt" 2>/dev/null || true
done
python3 "$ROOT/scripts/recordings_table.py" "$out" "${table_options[@]}" "${folders[@]}"
