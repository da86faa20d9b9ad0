#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/view.sh [RUN.mcap [RUN2.mcap] | EXPERIMENT] [options]
#
# Opens the viewer; prints the address of its page. RUN.mcap is the log of a run, two of them are shown side by side (the
# second robot as a ghost, its lines dashed). EXPERIMENT is a folder with experiment.yaml and CSV recordings. With no file
# it joins the run that goes on. All options go to hrp-viewer:
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

for argument in "$@"; do
  case "$argument" in
    -h | --help)
      print_help
      echo
      [ -x "$BUILD/bin/hrp-viewer" ] || "$ROOT/scripts/build.sh" hrp-viewer >&2
      exec "$BUILD/bin/hrp-viewer" --help
      ;;
  esac
done
"$ROOT/scripts/install_deps.sh" --viewer
"$ROOT/scripts/build.sh" hrp-viewer >&2
"$ROOT/scripts/build_page.sh"
exec "$BUILD/bin/hrp-viewer" "$@"
