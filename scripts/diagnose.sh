#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Finds what a simulation left out: diagnose.sh EXPERIMENT.yaml --out DIR [--jobs N]. Open DIR/report.html afterwards.
set -eu
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
tool="${BUILD:-$here/../build}/bin/hrp-diagnose"
if [ ! -x "$tool" ]; then
  echo "diagnose.sh: $tool is not there: run scripts/build.sh first" >&2
  exit 1
fi
exec "$tool" "$@"
