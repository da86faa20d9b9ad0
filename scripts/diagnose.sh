#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Finds what a simulation left out:
#   diagnose.sh EXPERIMENT.yaml --out DIR [--jobs N] [--patience F] [--resimulate servers|process]
# Open DIR/report.html afterwards. --resimulate runs the nominal and the updated scenario, through the server set or in
# one process, and compares both with a recording that nothing was fitted to.
set -eu
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
bin="${BUILD:-$here/../build}/bin"
if [ ! -x "$bin/hrp-diagnose" ]; then
  echo "diagnose.sh: $bin/hrp-diagnose is not there: run scripts/build.sh first" >&2
  exit 1
fi
again="" out="" previous="" count=$#
while [ "$count" -gt 0 ]; do
  count=$((count - 1))
  word=$1
  shift
  [ "$previous" = --out ] && out=$word
  if [ "$previous" = --resimulate ]; then
    again=$word previous=""
    continue
  fi
  previous=$word
  [ "$word" = --resimulate ] || set -- "$@" "$word"
done
case "$again" in
  "" | servers | process) ;;
  *) echo "diagnose.sh: --resimulate wants 'servers' or 'process', not '$again'" >&2; exit 2 ;;
esac
"$bin/hrp-diagnose" "$@"
[ -z "$again" ] || python3 "$here/diagnosis/resimulate.py" "$bin" "$out" "$again"
