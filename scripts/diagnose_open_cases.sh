#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/diagnose_open_cases.sh [FOLDER OF CASES] [OUT]
#
# Runs the tool on every case of a folder with known truths, and prints answer and truth side by side. The default folder
# is ../shared/cases/open. The reports go to OUT; default: a temporary folder.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cases=${1:-$ROOT/../shared/cases/open}
out=${2:-$(mktemp -d)}
if [ ! -d "$cases" ]; then
  echo "diagnose_open_cases.sh: there is no folder $cases" >&2
  exit 2
fi
for folder in "$cases"/*/; do
  name=$(basename "$folder")
  begin=$(date +%s)
  "$ROOT/scripts/diagnose.sh" "$folder/experiment.yaml" --out "$out/$name" --quiet >"$out/$name.txt" 2>&1 || echo "  (exit $?)"
  python3 - "$folder" "$out/$name" "$(($(date +%s) - begin))" <<'P'
import json, os, sys
folder, out, seconds = sys.argv[1:4]
truth = json.load(open(os.path.join(folder, 'truth.json')))
place = lambda h: next((str(h[k]) for k in ('joint', 'link', 'foot', 'sensor') if k in h), '')
said = json.load(open(os.path.join(out, 'report.json')))
hidden = ', '.join(f"{h['effect']}@{place(h)}" for h in truth['hidden']) or 'nothing'
found = ', '.join(f"{f['effect']}@{place(f['where'])}" for f in said['findings']) or said['verdict']
fit = said['fit']['validate']
print(f"{os.path.basename(os.path.normpath(folder)):10} {seconds:>4} s  truth: {hidden:60} said: {found:60} fit {fit['before']:.4g} -> {fit['after']:.4g}")
P
done
