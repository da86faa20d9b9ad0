# SPDX-License-Identifier: BSD-3-Clause
"""Which commands a document tells its reader to run: those of fenced blocks, and those in the text."""
import re

import rules

# In the text, a command begins with one of our scripts or programs, by its path. A name alone, such as `hrp-topic`, and
# a path of a file that is no program are no commands.
INLINE = re.compile(r"`((?:scripts/[\w/]+\.(?:sh|py)|build/bin/[\w-]+|example_c/[\w-]+|cmake )[^`]*)`")
LINK = re.compile(r"\[`[^`]*`\]\([^)]*\)")


class UnknownFence(Exception):
    pass


def strip(line):
    """A line of a block without the prompt and the remark behind it."""
    line = re.sub(r"^\$ ", "", line.strip())
    return re.sub(r"(^|\s{2,}|\s)#(\s.*)?$", "", line).strip()


def find_files(path):
    """Yields (name, text): YAML blocks that begin with '# name.yaml', which the document tells its reader to save."""
    text = path.read_text(encoding="utf-8")
    for block in re.findall(r"^```yaml\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        name = re.match(r"# ([\w-]+\.yaml)\n", block)
        if name:
            yield name.group(1), block


def find_commands(path):
    """Yields (line number, command)."""
    fence, held = None, ""
    for number, line in enumerate(open(path, encoding="utf-8").read().splitlines(), 1):
        mark = re.match(r"^\s*```(\w*)", line)
        if mark:
            fence = None if fence is not None else mark.group(1)
            if fence is not None and fence not in rules.COMMANDS | rules.NO_COMMANDS:
                raise UnknownFence(f"{path}:{number}: a block of '{fence}': commands, or not? say it in rules.py")
            continue
        if fence is None:
            for command in INLINE.findall(LINK.sub("", line)):
                yield number, command.strip()
        elif fence in rules.COMMANDS:
            held += strip(line)
            if held.endswith("\\"):
                held = held[:-1]
                continue
            if held:
                yield number, held
            held = ""
