#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""commands_page.py --bin build/bin [--check]

Writes docs/commands.md: every program and script with what it answers to --help. --check compares instead, and ends
with status 1 when the page is not what the programs say.
"""
import argparse
import difflib
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / 'docs' / 'commands.md'
INTRO = """# All commands
Every program and script answers `--help` and `--version` at once. `source share/completion/hrp.bash` completes programs,
commands, options and their values in bash. This page is what they say, written by `scripts/commands_page.py`; a test
compares it.

| status | meaning of every program's exit status |
|---|---|
| 0 | done; a run ended as planned, or was stopped |
| 1 | failed, or differs (`hrp-log compare`), or an input is damaged (`hrp-log info`) |
| 2 | the command line, scenario, model or file cannot be used |
"""
# Of the tests and of people who prove the tool; they answer --help like all others.
LEFT_OUT = re.compile(r'hrp-(odd-|diagnose-baseline|make-cases)')


def answer(words):
    # Wide, so that the terminal of whoever writes the page does not matter.
    run = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    if run.returncode:
        sys.exit('%s: status %d\n%s' % (' '.join(map(str, words)), run.returncode, run.stderr))
    return '\n'.join(line.rstrip() for line in run.stdout.replace(str(ROOT) + '/', '').strip().splitlines())


def find_commands(text):
    """Names under "Subcommands:"."""
    block = re.search(r'^Subcommands:\n((?:  .*\n?)+)', text, re.M)
    return re.findall(r'^  (\w[\w-]*)', block[1], re.M) if block else []


def make_page(folder):
    parts = [INTRO]
    parts.append('# Programs (`build/bin`)\n')
    for program in sorted(p for p in folder.iterdir() if p.name.startswith('hrp-') and not LEFT_OUT.match(p.name)):
        text = answer([program, '--help'])
        parts.append('## %s\n```text\n%s\n```\n' % (program.name, text))
        for command in find_commands(text):
            parts.append('### %s %s\n```text\n%s\n```\n' % (program.name, command, answer([program, command, '--help'])))
    parts.append('# Scripts (`scripts`)\n')
    for script in sorted((ROOT / 'scripts').glob('*.sh')):
        if script.name == 'lib.sh':
            continue
        # The options of the program behind it stand above.
        text = answer(['bash', script, '--help'])
        cut = re.search(r'All options go to (hrp-[a-z-]+):\n', text)
        parts.append('## %s\n```text\n%s\n```\n' % (script.name, text[:cut.end() - 1] if cut else text))
    return '\n'.join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bin', default=str(ROOT / 'build' / 'bin'), help='folder of the programs')
    parser.add_argument('--check', action='store_true', help='compare, do not write')
    options = parser.parse_args()
    page = make_page(pathlib.Path(options.bin).resolve())
    if not options.check:
        PAGE.write_text(page)
        return
    if page != PAGE.read_text():
        sys.stdout.writelines(difflib.unified_diff(PAGE.read_text().splitlines(True), page.splitlines(True), 'docs/commands.md', 'programs', n=1))
        sys.exit('docs/commands.md is not what the programs say: run scripts/commands_page.py')


if __name__ == '__main__':
    main()
