# SPDX-License-Identifier: BSD-3-Clause
"""tidy.py ROOT BUILD JOBS [NAME ...]: clang-tidy over the sources of ours; scripts/tidy.sh says how to call it."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import subprocess
import sys

OURS = ("common", "servers", "controller", "diagnosis", "python", "tests", "idl")


def find_sources(root, build, names):
    """Those of the compile commands, below one of the names."""
    wanted = [(root / name).resolve() for name in names] or [root / folder for folder in OURS]
    sources = {pathlib.Path(entry["file"]) for entry in json.loads((build / "compile_commands.json").read_text())}
    return sorted(source for source in sources if any(folder == source or folder in source.parents for folder in wanted))


def hash_rest(root):
    """Of all that a source may depend on beside itself: headers of ours, and the checks."""
    state = hashlib.sha256((root / ".clang-tidy").read_bytes())
    for folder in OURS:
        for header in sorted((root / folder).rglob("*.h")):
            state.update(header.read_bytes())
    return state.hexdigest()


def look(source, build, rest):
    """What clang-tidy says of a source; empty when nothing."""
    key = hashlib.sha256((rest + str(source)).encode() + source.read_bytes()).hexdigest()
    clean = build / "clean" / key
    if clean.exists():
        return ""
    done = subprocess.run(["clang-tidy", "-p", str(build), "--quiet", str(source)], capture_output=True, text=True)
    if done.returncode == 0:
        clean.touch()
        return ""
    return done.stdout + done.stderr


def main():
    root, build, jobs = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), int(sys.argv[3])
    sources, rest, bad = find_sources(root, build, sys.argv[4:]), hash_rest(root), []
    if not sources:
        sys.exit("tidy.sh: there is no source below these names")
    os.makedirs(build / "clean", exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for number, (source, said) in enumerate(zip(sources, pool.map(lambda s: look(s, build, rest), sources)), 1):
            if said:
                bad.append(source)
                print(said, flush=True)
            if sys.stderr.isatty():
                sys.stderr.write(f"\r\x1b[K{number} of {len(sources)} {source.relative_to(root)}")
    print(f"{len(sources)} files, {len(bad)} with findings")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
