# SPDX-License-Identifier: BSD-3-Clause
"""clang-tidy over many sources in one unit, which reads headers once: without its analyser 2 s of a core for a source instead
of 10. scripts/tidy.sh makes the build folder, so call it before. Prints each finding, and how many sources it saw. With the
analyser, it skips and marks clean sources as scripts/tidy.sh does.

  python3 scripts/robustness/tidy_units.py build-tidy [--analyser] [FOLDER or FILE ...]
"""
import argparse
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

import tidy

LARGEST = 16  # sources in a unit: with more, a unit takes more than 1 GB
# The analyser follows paths in the main file only, unless the main file's name ends so. Then also in sources that it includes.
UNIT = "UnifiedSource.cpp"
QUICK = ("--checks=-clang-analyzer-*",)
# A unit may have each of these once. They get a number.
ENTRIES = ("main", "LLVMFuzzerTestOneInput")
# What begins a line and defines a name of the source's own: a type, an alias, a function or a constant.
DEFINED = (r"(?:template.*> )?(?:struct|class|enum class|enum) (\w+)", r"using (\w+) =", r"[\w:<>,&*\[\] ]*?[ *&](\w+)(?:\(|\[| =|\{|;)")


def find_flags(build):
    """Of each source: what the compiler is told of folders, macros and language. A pair is one item."""
    flags = {}
    for command in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words = iter(shlex.split(command["command"].partition("clang++ ")[2]))
        mine = flags.setdefault(pathlib.Path(command["file"]), [])
        for word in words:
            if word == "-o":
                next(words)
            elif word in ("-isystem", "-I"):
                mine.append((word, next(words)))
            elif word.startswith("-") and word != "-c" and not word.startswith("-fvisibility"):  # the header has the default
                mine.append((word,))
    return flags


def read_names(source):
    """Names that a source defines on lines without an indent, and all that it uses beside members."""
    text = re.sub(r"//.*|/\*.*?\*/", "", source.read_text(encoding="utf-8"))
    text = re.sub(r'"(\\.|[^"\\])*"', '""', text)
    defined = set()
    for line in text.split("\n"):
        found = [match for match in (re.match(pattern, line) for pattern in DEFINED) if match and line[0] not in " }#"]
        if found and not found[0].group(1).startswith("TEST"):
            defined.add(found[0].group(1))
        defined |= set(re.findall(r", (k[A-Z]\w*) =", line))
    return defined - set(ENTRIES), set(re.findall(r"(?<![.\w>])\b([A-Za-z_]\w*)", text))


def make_units(sources, flags):
    """Sources share a unit when none uses a name that another defines, and all have the same macros."""
    units = []
    for source in sources:
        defined, used = read_names(source)
        macros = {word for item in flags[source] for word in item if word.startswith(("-D", "-std"))}
        for unit in units:
            apart = not (defined & unit["used"] or unit["defined"] & used)
            if apart and macros == unit["macros"] and len(unit["sources"]) < LARGEST:
                break
        else:
            units.append(unit := {"sources": [], "defined": set(), "used": set(), "macros": macros})
        unit["sources"].append(source)
        unit["defined"] |= defined
        unit["used"] |= used
    return [unit["sources"] for unit in units]


def look(sources, build, flags, checks=QUICK):
    """What clang-tidy says of a unit. One that cannot be compiled is halved."""
    lines = []
    for number, source in enumerate(sources):
        lines += [f"#undef {name}\n#define {name} {name}_{number}" for name in ENTRIES] + [f'#include "{source}"']
    words = dict.fromkeys(item for source in sources for item in flags[source])
    header = [f"--extra-arg={word}" for word in ("-include-pch", str(build / "headers.pch"))]
    plugin = [f"--load={build / 'own_sources.so'}"] if (build / "own_sources.so").exists() else []
    with tempfile.NamedTemporaryFile("w", dir=build, suffix=UNIT, encoding="utf-8") as unit:  # another call has other units
        unit.write("\n".join(lines) + "\n")
        unit.flush()
        done = subprocess.run(["clang-tidy", "--quiet", *checks, f"--header-filter=^{tidy.ROOT}/", *plugin, *header,
                               unit.name, "--", *(word for item in words for word in item), "-fPIC", "-fno-semantic-interposition"],
                              capture_output=True, text=True)
    said = tidy.drop_eigen(done.stdout)
    if done.returncode and not done.stdout:
        return f"clang-tidy ended with status {done.returncode} and without a word: {' '.join(map(str, sources))}\n"
    if "[clang-diagnostic-error" not in said or len(sources) == 1:
        return said
    half = len(sources) // 2
    return look(sources[:half], build, flags, checks) + look(sources[half:], build, flags, checks)


def main():
    parser = argparse.ArgumentParser(prog="tidy_units.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--analyser", action="store_true", help="all checks, also those that follow paths")
    options = parser.parse_intermixed_args()
    checks = () if options.analyser else QUICK
    build = options.build.resolve()
    sources = tidy.find_sources(build)
    if options.names:
        sources = tidy.select_named(sources, options.names)
    flags = find_flags(build)
    marks = {source: build / "clean" / tidy.hash_all(source) for source in sources if source.suffix == ".cpp"}
    sources = [source for source, mark in marks.items() if not (options.analyser and mark.exists())]
    findings = ""
    for unit in make_units(sources, flags):
        said = look(unit, build, flags, checks)
        findings += said
        print(said, end="", flush=True)
        for source in unit if options.analyser and not said else ():
            marks[source].touch()
    print(f"{len(sources)} sources, {'findings above' if findings else 'no finding'}")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
