#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# build.sh OUT: fetches the pinned packages once, and bundles the page into OUT when a source of it is newer. The bundle
# fetches nothing from elsewhere.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
out="$1"
cd "$here"
if [ -f "$out/viewer.js" ] && [ -z "$(find . -path ./node_modules -prune -o -type f -newer "$out/viewer.js" -print -quit)" ]; then
  exit 0
fi
if [ ! node_modules/.package-lock.json -nt package-lock.json ]; then
  if ! output="$(npm ci --no-audit --no-fund --loglevel=error 2>&1)"; then
    printf '%s\n' "$output" >&2
    echo "viewer: the packages of servers/viewer/page/package-lock.json could not be fetched. Is the npm registry" >&2
    echo "reachable? 'npm ci' must work once in servers/viewer/page; later builds need no network." >&2
    exit 1
  fi
fi
mkdir -p "$out"
node_modules/.bin/esbuild src/viewer.js src/viewer.css --bundle --minify --format=esm --target=chrome100,firefox100,safari15 \
  --legal-comments=linked --log-level=warning --outdir="$out.new"
cp index.html "$out.new/"
# viewer.js last: its age says that the rest is there.
for file in "$out.new"/*; do
  [ "$(basename "$file")" = viewer.js ] || mv -f "$file" "$out/"
done
mv -f "$out.new/viewer.js" "$out/"
touch "$out/viewer.js"
rmdir "$out.new"
