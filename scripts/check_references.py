#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Finds files and folders that comments and documents name, and that do not exist.

scripts/check_references.py [ROOT]    prints each as file:line and ends with status 1 when there is one

A name counts as found when a file or folder of the tree ends with it: `search/trial.h` is `diagnosis/search/trial.h`.
Links of documents must lead to a file from the document's own folder.
"""
import pathlib
import re
import sys

from check_includes import find_files

DOCUMENTS = {".md"}
SLASHES = {".h", ".cpp", ".c", ".idl", ".mjs", ".ts", ".js"}
HASHES = {".py", ".sh", ".cmake", ".yaml", ".yml"}
OURS = r"(?:h|cpp|md|py|sh|idl|mjs|cmake)"
# `docs/x.md`, `search/trial.h`, `x.h`; the first character keeps URLs, variables and absolute paths out.
NAMED_FILE = re.compile(rf"(?<![\w./$}}<*~:-])((?:[\w-]+/)*[\w-]+(?:\.[\w-]+)*\.{OURS})(?![\w/*])")
# `servers/dynamics`, `diagnosis/search/`: folders of ours by their first name.
NAMED_FOLDER = re.compile(r"(?<![\w./$}<*~:-])((?:common|servers|controller|diagnosis|tests|models|idl|docs)/[\w/-]+)(?![\w.*{<\[]|/[*{<])")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
STRING = re.compile(r'"(?:[^"\\]|\\.)*"')

# Made by a build, by a run or by a reader; or of other projects.
NOT_OURS = re.compile(r"^(build|out|logs|hrp_idl|experiment|compared|example_c|mine)/"
                      r"|^[a-z]\.\w+$|^(NAME|DIR)\b")
# Names what is not there on purpose.
NOT_READ = {"tests/documents/no_rule.md", "scripts/check_references.py"}


def get_comment(path, line):
    """The part of a line that is a comment; all of it in a document."""
    if path.suffix in DOCUMENTS:
        return line
    if path.suffix in SLASHES:
        found = re.search(r"//(.*)|^\s*\*(.*)|/\*(.*)", STRING.sub('""', line))
        return next((part for part in found.groups() if part), "") if found else ""
    found = re.search(r"(?:^|\s)#(.*)", STRING.sub('""', line))
    return found.group(1) if found else ""


class Tree:
    """Every way to name a file or a folder of the tree: its path and all ends of it."""

    def __init__(self, files):
        self.files = set(files)
        self.ends = set()
        for file in files:
            parts = file.split("/")
            for last in range(1, len(parts) + 1):
                for first in range(last):
                    self.ends.add("/".join(parts[first:last]))

    def has(self, name):
        name = name.rstrip("/")
        if name.endswith(".h") and name[:-2] + ".idl" in self.ends:
            return True  # made of the IDL by its compiler
        if name in self.ends or NOT_OURS.search(name + ("/" if "/" not in name and "." not in name else "")):
            return True
        # `servers/dynamics/node` is all files that begin so.
        return any(file.startswith(name + ".") for file in self.files)


def check_links(path, line, root):
    for target in LINK.findall(line):
        if not re.match(r"\w+:", target) and not (root / path).parent.joinpath(target).exists():
            yield f"a link to '{target}', which does not exist"


def check_line(path, line, tree, root):
    file = pathlib.Path(path)
    if file.suffix in DOCUMENTS:
        yield from check_links(path, line, root)
        line = LINK.sub("]", line)
    comment = get_comment(file, line)
    names = NAMED_FILE.findall(comment)
    names += [name for name in NAMED_FOLDER.findall(comment) if not any(other.startswith(name) for other in names)]
    for name in names:
        if not tree.has(name):
            yield f"names '{name}', which does not exist"


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    files = [f for f in find_files(str(root)) if (root / f).is_file()]
    tree, problems, count = Tree(files), [], 0
    for path in sorted(files):
        if path in NOT_READ:
            continue
        if pathlib.Path(path).suffix not in DOCUMENTS | SLASHES | HASHES and not path.endswith("CMakeLists.txt"):
            continue
        count += 1
        for number, line in enumerate((root / path).read_text(encoding="utf-8", errors="replace").splitlines(), 1):
            problems += [f"{path}:{number}: {text}" for text in check_line(path, line, tree, root)]
    print("\n".join(problems) if problems else f"{count} files name nothing that is not there")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
