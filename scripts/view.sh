#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/view.sh [RUN.mcap [RUN2.mcap] | EXPERIMENT] [options]
#
# Starts the viewer and prints the address of its page. RUN.mcap is the log of a run. With two logs, the second robot is a
# ghost, and its lines are dashed. EXPERIMENT is a folder with experiment.yaml and CSV recordings. Without a file, the viewer
# joins the live run. All options go to hrp-viewer:
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
