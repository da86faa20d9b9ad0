#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""docs/equations.md against the code, both ways: every row names a function, file and test that exist and a file that
carries the tag; every tag in the code has a row with its equation."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("common", "servers", "controller", "diagnosis")
TAG = re.compile(r"\[(H03|M14) (eqs?\.|section) ([0-9., and]+)\]")


def find_tags(text):
    """Pairs (paper, 'eq. 3') of all tags in a text; '[H03 eq. 1, 3]' counts twice."""
    for paper, kind, numbers in TAG.findall(text):
        kind = "section" if kind == "section" else "eq."
        for number in re.findall(r"[0-9]+(?:\.[0-9]+)*", numbers):
            yield paper, f"{kind} {number}"


def read_rows(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) == 5 and cells[0] in ("H03", "M14"):
            yield number, cells


def check_row(number, cells):
    paper, equation, function, file, test = cells
    source = ROOT / file
    where = f"docs/equations.md:{number}"
    if not source.is_file():
        return [f"{where}: no file {file}"]
    text = source.read_text()
    faults = []
    if (paper, equation) not in set(find_tags(text)):
        faults.append(f"{where}: {file} has no tag [{paper} {equation}]")
    if not re.search(rf"\b{re.escape(function)}\(", text):
        faults.append(f"{where}: {file} has no function {function}")
    test_file, _, name = (part.strip() for part in test.partition(":"))
    if not (ROOT / test_file).is_file() or name not in (ROOT / test_file).read_text():
        faults.append(f"{where}: no test {name} in {test_file}")
    return faults


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    rows = list(read_rows(ROOT / "docs/equations.md"))
    faults = [fault for number, cells in rows for fault in check_row(number, cells)]
    known = {(cells[0], cells[1]) for _, cells in rows}
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            for tag in sorted(set(find_tags(path.read_text())) - known):
                faults.append(f"{path.relative_to(ROOT)}: tag [{tag[0]} {tag[1]}] has no row in docs/equations.md")
    if not rows:
        faults.append("docs/equations.md has no rows")
    print("\n".join(faults) if faults else f"{len(rows)} equations found, all in place")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
