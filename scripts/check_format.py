#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that every C and C++ file is laid out as .clang-format says, and that no line chains assignments with commas. Another
version of clang-format would lay out other lines: then the layout is not checked, and a line says so.

scripts/check_format.py          prints each file that differs, and ends with status 1 when there is one
scripts/check_format.py --fix    lays out these files
"""
import pathlib
import re
import subprocess
import sys

from check_includes import find_files

ROOT = pathlib.Path(__file__).resolve().parent.parent
VERSION = '14'  # Debian 12's


def find_version():
    try:
        said = subprocess.run(['clang-format', '--version'], capture_output=True, text=True).stdout
    except FileNotFoundError:
        return None
    found = re.search(r'version (\d+)', said)
    return found and found[1]


def list_files():
    return [name for name in find_files(ROOT) if name.endswith(('.c', '.cpp', '.h')) and (ROOT / name).exists()]


def list_different(files):
    said = subprocess.run(['clang-format', '--dry-run', *files], cwd=ROOT, capture_output=True, text=True, check=True).stderr
    different = set(re.findall(r'^(.+?):\d+:\d+: warning: code should be clang-formatted', said, re.MULTILINE))
    return [name for name in files if name in different]


ASSIGNMENT = r'[*\w][\w.:>()\[\]-]*\s(?:[-+*/|&]?=)\s'
CHAIN = re.compile(rf'^\s*{ASSIGNMENT}.*, {ASSIGNMENT}')


def remove_brackets(line):
    """The line without what stands in brackets or strings, and without its comment."""
    line = re.sub(r'"(?:\\.|[^"\\])*"|//.*', '', line)
    while True:
        shorter = re.sub(r'\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}', '', line)
        if shorter == line:
            return line.rstrip()
        line = shorter


def find_chains(text):
    """Numbers of the lines that assign twice: `a = 1, b = 2;`. Lines that go on with a declaration do not count."""
    before, found = ';', []
    for number, line in enumerate(text.splitlines(), 1):
        code = remove_brackets(line)
        if before.endswith((';', '{', '}', ')', ':', 'else')) and CHAIN.match(code):
            found.append(number)
        before = code or before
    return found


def report_chains(files):
    chains = [(name, number) for name in files for number in find_chains((ROOT / name).read_text())]
    for name, number in chains:
        print(f'{name}:{number}: assigns twice: one assignment a statement')
    return len(chains)


def main():
    if {'-h', '--help'} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    files = list_files()
    chains = report_chains(files)
    version = find_version()
    if version != VERSION:
        print(f'NOT CHECKED: needs clang-format {VERSION} (Debian 12: apt-get install clang-format), found {version or "none"}')
        return 1 if chains else 0
    different = list_different(files)
    fix = '--fix' in sys.argv[1:]
    if fix and different:
        subprocess.run(['clang-format', '-i', *different], cwd=ROOT, check=True)
    for name in different:
        print(f'{name}: {"laid out" if fix else "not laid out as .clang-format says; scripts/check_format.py --fix does it"}')
    print(f'{len(files)} files, {len(different)} {"changed" if fix else "differ"}')
    return 1 if chains or (different and not fix) else 0


if __name__ == '__main__':
    sys.exit(main())
