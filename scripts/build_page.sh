#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/build_page.sh
#
# Bundles the page of the viewer into build/share/viewer, unless it is up to date. Needs Node 18 or newer, and the npm
# registry once.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
case "${1:-}" in -h | --help) print_help; exit 0 ;; esac

"$ROOT/servers/viewer/page/build.sh" "$BUILD/share/viewer"
