#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Fetches the pinned npm packages that the tests of the viewer use; nothing to do once they are there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
if [ node_modules/.package-lock.json -nt package-lock.json ]; then
  exit 0
fi
if ! output="$(npm ci --no-audit --no-fund --loglevel=error 2>&1)"; then
  printf '%s\n' "$output" >&2
  echo "tests/browser: the packages of tests/browser/package-lock.json could not be fetched, so the viewer cannot be" >&2
  echo "tested. Is the npm registry reachable? 'npm ci' in tests/browser must work once; later runs need no network." >&2
  exit 1
fi
