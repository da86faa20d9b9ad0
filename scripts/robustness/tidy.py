# SPDX-License-Identifier: BSD-3-Clause
"""clang-tidy over sources of ours; scripts/tidy.sh says how to call it."""
import argparse
import concurrent.futures
import functools
import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OURS = ("common", "servers", "controller", "diagnosis", "python", "tests", "idl")


def find_sources(build):
    """Of ours, those of the compile commands."""
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    files = {pathlib.Path(command["file"]) for command in commands}
    return sorted(file for file in files if any(ROOT / folder in file.parents for folder in OURS))


def find_changed():
    """Files that differ from the branch main, or from the last commit where it is checked out; new ones, too."""
    def ask(*words):
        done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"tidy.sh: what has changed is not known, so say --all or names: {done.stderr.strip()}")
        return done.stdout.split()
    base = ask("merge-base", "main", "HEAD")[0]
    return {ROOT / name for name in ask("diff", "--name-only", base) + ask("ls-files", "--others", "--exclude-standard")}


def select_changed(sources, changed):
    """Those that changed, or that include a header which did."""
    headers = {str(file.relative_to(ROOT)) for file in changed if file.suffix == ".h"}

    def is_meant(source):
        included = re.findall(r'^#include "([^"]+)"', source.read_text(encoding="utf-8"), re.M)
        return source in changed or not headers.isdisjoint(included)
    return [source for source in sources if is_meant(source)]


def select_named(sources, names):
    wanted = [path.resolve() if path.exists() else ROOT / path for path in map(pathlib.Path, names)]
    return [source for source in sources if any(name == source or name in source.parents for name in wanted)]


@functools.lru_cache(maxsize=None)
def find_included(file):
    """Headers of ours that a file includes itself. Include paths start at the top of the tree."""
    names = re.findall(r'^#include "([^"]+)"', file.read_text(encoding="utf-8"), re.M)
    return [ROOT / name for name in names if (ROOT / name).exists()]


def hash_all(source):
    """Of all that the answer depends on: the checks, the source, and headers of ours that it includes, directly or not."""
    files, waiting = {source}, [source]
    while waiting:
        added = set(find_included(waiting.pop())) - files
        files |= added
        waiting += added
    state = hashlib.sha256((ROOT / ".clang-tidy").read_bytes())
    for file in sorted(files):
        state.update(str(file).encode() + file.read_bytes())
    return state.hexdigest()


def drop_eigen(said):
    """Without findings whose place is in Eigen: the analyser takes memory that Eigen fills for memory that nobody fills."""
    findings = re.split(r"^(?=\S+:\d+:\d+: (?:error|warning): )", said, flags=re.M)
    return "".join(finding for finding in findings if "/eigen3/" not in finding.split(":", 1)[0])


def look(source, build, options):
    """What clang-tidy says of a source; empty when nothing."""
    clean = build / "clean" / hash_all(source)
    if clean.exists():
        return ""
    done = subprocess.run(["clang-tidy", "-p", str(build), "--quiet", *options, str(source)], capture_output=True, text=True)
    said = drop_eigen(done.stdout)
    if done.returncode == 0 or (done.stdout and not said):
        clean.touch()
        return ""
    # It counts the warnings of the system's headers, which it does not show.
    said += "".join(line for line in done.stderr.splitlines(True) if not re.match(r"\d+ warnings? ", line))
    return said or f"{source}: clang-tidy ended with status {done.returncode} and without a word\n"


def look_at_all(sources, build, jobs, options):
    """(source, words) of each, and the progress on a terminal."""
    (build / "clean").mkdir(exist_ok=True)
    find_included.cache_clear()
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for number, (source, words) in enumerate(zip(sources, pool.map(lambda s: look(s, build, options), sources)), 1):
            yield source, words
            if sys.stderr.isatty():
                sys.stderr.write(f"\r\x1b[K{number} of {len(sources)}: {source.relative_to(ROOT)}")
    if sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K")


def print_table(seen):
    """Folder by folder: how many sources, and how many with findings."""
    print("| folder | sources | with findings |\n|---|---|---|")
    for folder in OURS:
        bad = [bool(words) for source, words in seen if ROOT / folder in source.parents]
        if bad:
            print(f"| {folder} | {len(bad)} | {sum(bad)} |")


def main():
    parser = argparse.ArgumentParser(prog="tidy.sh")
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--option", action="append", default=[], help="of clang-tidy, for all sources")
    options = parser.parse_intermixed_args()  # names after options, too
    sources = find_sources(options.build)
    if options.names:
        sources = select_named(sources, options.names)
        if not sources:
            sys.exit("tidy.sh: a build makes nothing of what lies there")
    elif not options.all:
        sources = select_changed(sources, find_changed())
    seen = []
    for source, words in look_at_all(sources, options.build, options.jobs, options.option):
        seen.append((source, words))
        if words:
            print(words, flush=True)
    print_table(seen)
    return 1 if any(words for _, words in seen) else 0


if __name__ == "__main__":
    sys.exit(main())
