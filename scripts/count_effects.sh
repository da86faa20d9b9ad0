#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/count_effects.sh [COMMIT]
#
# Counts how often code outside the table of effects mentions single effects, in the commit (default: HEAD). The results
# are in docs/effects.md.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
commit=${1:-HEAD}
cd "$ROOT"
code() { git grep "$@" "$commit" -- 'diagnosis/*.cpp' 'diagnosis/*.h' 'servers/*.cpp' 'servers/*.h' 'common/*.cpp' \
  'common/*.h' ':!common/effects' ':!diagnosis/generator' ':!diagnosis/evidence' || true; }
id='\b(EffectId|StandId|I|TossId|RowEffectId|E)::k[A-Z][A-Za-z]*'
rows='diagnosis/(standing/(effect|sensor)_rows|toss/effects)\.cpp'
echo "mentions of an effect outside the table: $(code -hoE "$id" | wc -l) in $(code -lE "$id" | wc -l) files"
echo "  of these in the rows of engines: $(code -oE "$id" | grep -cE "$rows")"
echo "enumerations of effects: $(git grep -hE 'enum class (EffectId|StandId|TossId|RowEffectId|TermKind)' "$commit" -- '*.h' | wc -l)"
echo "files that know a parallel spring: $(code -lE 'kSpring\b|parallel_spring|spring_stiffness' | wc -l)"
limit() { git grep -lE '"velocity_limit"' "$commit" -- "$@" | wc -l; }
echo "files that know a velocity limit: $(limit 'common/effects/*.cpp') in the table, $(limit 'diagnosis/generator/*.cpp') in the generator, $(code -lE '"velocity_limit"' | wc -l) elsewhere"
# Generator, identification and page are no part of the diagnosis; evidence came after the goals were set.
lines() { git ls-tree -r --name-only "$commit" diagnosis | grep -E '\.(cpp|h)$' | grep -vE "/(generator|identification|page$1)/" |
  while read -r file; do git show "$commit:$file"; done | wc -l; }
constants() { git grep -hE '^ *(static )?constexpr (double|int|size_t|float) k' "$commit" -- 'diagnosis/*.cpp' 'diagnosis/*.h' \
  ':!diagnosis/generator' ':!diagnosis/identification' ':!diagnosis/page' "$@" | wc -l; }
echo "lines of the diagnosis: $(lines '|evidence'), with evidence $(lines '')"
echo "tuning constants: $(constants ':!diagnosis/evidence'), with evidence $(constants)"
echo "mentions of an effect in evidence: $(git grep -hoE "$id" "$commit" -- diagnosis/evidence | wc -l)"
