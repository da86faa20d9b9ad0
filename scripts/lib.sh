# SPDX-License-Identifier: BSD-3-Clause
# Shared by the scripts of this folder: source it. Sets ROOT and BUILD.
ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
BUILD="${HRP_BUILD_DIR:-$ROOT/build}"

say() { printf '%s\n' "$*" >&2; }
fail() { say "$(basename "$0"): $*"; exit 1; }

# print_help: the comment block at the top of the calling script, without its first two lines.
print_help() { awk 'NR > 2 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$0"; }

# Ninja redraws one line on a terminal. Elsewhere (a log of a CI machine) one line per tenth of the way is enough,
# and whatever compilers say.
run_ninja() {
  if [ -t 1 ]; then
    ninja -C "$BUILD" -j "$(nproc)" "$@"
    return
  fi
  ninja -C "$BUILD" -j "$(nproc)" "$@" | awk '
    match($0, /^\[[0-9]+\/[0-9]+\]/) {
      split(substr($0, 2, RLENGTH - 2), n, "/")
      tenth = int(10 * n[1] / n[2])
      if (tenth > last || n[1] == n[2]) { print "build " n[1] "/" n[2]; fflush(); last = tenth }
      next
    }
    /^ninja: (Entering directory|no work to do)/ { next }
    { print; fflush() }'
}

# configure [cmake options]: makes the build folder when it is not there or lacks what is asked for.
configure() {
  mkdir -p "$BUILD"
  if ! cmake -S "$ROOT" -B "$BUILD" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" > "$BUILD/configure.log" 2>&1; then
    cat "$BUILD/configure.log" >&2
    fail "cmake could not configure the build; its words are above and in $BUILD/configure.log"
  fi
}
