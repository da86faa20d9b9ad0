#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Fetches the pinned npm packages that the log test reads with; nothing to do once they are there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
if [ node_modules/.package-lock.json -nt package-lock.json ]; then
  exit 0
fi
if ! output="$(npm ci --no-audit --no-fund --loglevel=error 2>&1)"; then
  printf '%s\n' "$output" >&2
  echo "tests/npm: the packages of tests/npm/package-lock.json could not be fetched, so no foreign reader can check our" >&2
  echo "logs. Is the npm registry reachable? 'npm ci' in tests/npm must work once; later runs need no network." >&2
  exit 1
fi
