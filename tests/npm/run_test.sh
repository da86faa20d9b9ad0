#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# run_test.sh MAKE_LOG HRP_LOG COMPRESSION: a log of our logger, read by other people's readers.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
if [ ! -d "$here/node_modules" ]; then
  echo "tests/npm/node_modules is not there; tests/npm/install.sh fetches it (scripts/test.sh does so by itself)" >&2
  exit 1
fi
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
"$1" "$folder/log.mcap" "$3"
node "$here/read_log.mjs" "$2" "$folder/log.mcap"
