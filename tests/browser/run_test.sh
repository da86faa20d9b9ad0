#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# run_test.sh TEST BIN_FOLDER [chromium]: one test of the viewer; status 77 = skipped, and why.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
test="$1"
export HRP_BIN="$2"
if [ ! -d "$here/node_modules" ]; then
  echo "tests/browser/node_modules is not there; tests/browser/install.sh fetches it (scripts/test.sh does so by itself)" >&2
  exit 1
fi
if [ "${3:-}" = chromium ]; then
  HRP_CHROMIUM="$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)"
  export HRP_CHROMIUM
  if [ -z "$HRP_CHROMIUM" ]; then
    echo "SKIPPED: no Chromium on this machine, so the page of the viewer was NOT tested (apt-get install chromium)" >&2
    exit 77
  fi
  if [ ! -f "$HRP_BIN/../share/viewer/viewer.js" ]; then
    echo "build/share/viewer is not there; scripts/build_page.sh makes it (scripts/test.sh does so by itself)" >&2
    exit 1
  fi
fi
HRP_TEST_FOLDER="$(mktemp -d)"
export HRP_TEST_FOLDER
trap 'rm -rf "$HRP_TEST_FOLDER"' EXIT
node "$here/$test"
