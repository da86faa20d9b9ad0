# SPDX-License-Identifier: BSD-3-Clause
# Shared by the scripts of this folder: source it. Sets ROOT and BUILD. Answers --help and --version for every script, at
# once: nothing is installed, built or written for a question.
ROOT="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
BUILD="${HRP_BUILD_DIR:-$ROOT/build}"

say() { printf '%s\n' "$*" >&2; }
fail() { say "$(basename "$0"): $*"; exit 1; }
# For words of a command line and files that cannot be used, as the programs refuse them.
refuse() { say "$(basename "$0"): $*"; exit 2; }

# print_help: the comment block at the top of the calling script, without its first two lines; and the options of the
# program that "All options go to", as the program says them, or where it is not built, as docs/commands.md does.
print_help() {
  awk 'NR > 2 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$0"
  local program
  program="$(sed -n 's/^# .*All options go to \(hrp-[a-z-]*\):$/\1/p' "$0")"
  if [ -z "$program" ]; then return; fi
  echo
  if [ -x "$BUILD/bin/$program" ]; then "$BUILD/bin/$program" --help; return; fi
  awk -v title="## $program" '$0 == title { found = 1 } found && /^```/ { if (inside) exit; inside = 1; next } inside' "$ROOT/docs/commands.md"
}

# A sourced file sees the arguments of the script.
for argument in "$@"; do
  case "$argument" in
    -h | --help) print_help; exit 0 ;;
    --version) echo "$(basename "$0") (openhrp-dds) $(sed -n 's/^project(.* VERSION \([0-9.]*\).*/\1/p' "$ROOT/CMakeLists.txt")"; exit 0 ;;
  esac
done

# Progress of the build with an estimate of the time left: one line that is redrawn on a terminal, a line per tenth of the
# way elsewhere (a log of a CI machine); and whatever compilers say.
run_ninja() {
  NINJA_STATUS="[%f/%t %e] " ninja -C "$BUILD" -j "$(nproc)" "$@" | python3 "$ROOT/scripts/build_progress.py"
}

# configure [cmake options]: makes the build folder when it is not there or lacks what is asked for.
configure() {
  mkdir -p "$BUILD"
  if ! cmake -S "$ROOT" -B "$BUILD" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" > "$BUILD/configure.log" 2>&1; then
    cat "$BUILD/configure.log" >&2
    fail "cmake could not configure the build; its words are above and in $BUILD/configure.log"
  fi
}

# answer ANSWER EXPERIMENT.yaml LIMIT [options]: asks hrp-diagnose once. ANSWER/run.json says that it is done, how it ended and
# the seconds. A run that failed or took longer than LIMIT leaves no report: a first answer alone is none.
answer() {
  local answer=$1 begin seconds status=0
  [ ! -e "$answer/run.json" ] || return 0
  mkdir -p "$answer"
  begin=$(date +%s.%N)
  timeout "$3" "$BUILD/bin/hrp-diagnose" "$2" --out "$answer" "${@:4}" >"$answer/terminal.txt" 2>&1 || status=$?
  seconds=$(awk "BEGIN {printf \"%.1f\", $(date +%s.%N) - $begin}")
  [ "$status" -eq 0 ] || rm -f "$answer/report.json"
  echo "{\"status\": $status, \"seconds\": $seconds}" >"$answer/run.json"
  say "$answer: status $status, $seconds s"
}
