#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""help_test.py BIN: every program and script answers --help and --version at once, builds nothing and writes nothing;
docs/commands.md is what they say; bash completes from it."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(sys.argv.pop(1)).resolve()
VERSION = re.search(r'^project\(.* VERSION ([0-9.]+)', (ROOT / 'CMakeLists.txt').read_text(), re.M)[1]
SCRIPTS = sorted(p for p in (ROOT / 'scripts').glob('*.sh') if p.name != 'lib.sh')
PROGRAMS = sorted(p for p in BIN.iterdir() if p.name.startswith('hrp-') or p.name == 'my-controller')


def ask(words, folder, **more):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, cwd=folder, timeout=60, stdin=subprocess.DEVNULL, **more)


class Questions(unittest.TestCase):
    def check(self, words, environment=None):
        for question, expected in (('--help', r'.{40}'), ('--version', r'\(openhrp-dds\) ' + re.escape(VERSION))):
            with self.subTest(command=words[-1].name, question=question), tempfile.TemporaryDirectory() as folder:
                answer = ask(words + [question], folder, env=environment)
                self.assertEqual(answer.returncode, 0, answer.stderr)
                self.assertRegex(answer.stdout.replace('\n', ' '), expected)
                self.assertEqual(os.listdir(folder), [], 'a question leaves no file')

    def test_programs_answer_and_write_nothing(self):
        self.assertGreater(len(PROGRAMS), 10)
        for program in PROGRAMS:
            self.check([program])

    def test_programs_refuse_what_they_do_not_know_with_status_2(self):
        with tempfile.TemporaryDirectory() as folder:
            for program in PROGRAMS:
                answer = ask([program, '--no-such-option'], folder)
                self.assertEqual(answer.returncode, 2, f'{program.name}: {answer.stdout}{answer.stderr}')

    def test_scripts_answer_without_a_build(self):
        with tempfile.TemporaryDirectory() as folder:
            nowhere = os.path.join(folder, 'build')
            for script in SCRIPTS:
                self.check(['bash', script], dict(os.environ, HRP_BUILD_DIR=nowhere, BUILD=nowhere))
            self.assertFalse(os.path.exists(nowhere), 'nothing was built for a question')

    def test_a_script_lists_the_options_of_its_program_before_it_is_built(self):
        with tempfile.TemporaryDirectory() as folder:
            answer = ask(['bash', ROOT / 'scripts' / 'simulate.sh', '--help'], folder, env=dict(os.environ, HRP_BUILD_DIR=folder + '/none'))
            self.assertIn('--dds-for', answer.stdout)

    def test_the_page_of_commands_is_what_they_say(self):
        answer = ask([sys.executable, ROOT / 'scripts' / 'commands_page.py', '--bin', BIN, '--check'], ROOT)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)


class Completion(unittest.TestCase):
    def complete(self, line):
        words = line.split(' ')
        script = 'source "$1"; COMP_WORDS=("${@:2}"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _hrp; printf "%s\\n" "${COMPREPLY[@]}"'
        words[0] = str(BIN / words[0])
        return ask(['bash', '-c', script, 'bash', ROOT / 'share' / 'completion' / 'hrp.bash'] + words, ROOT).stdout.split()

    def test_commands_options_and_values(self):
        self.assertEqual(self.complete('hrp-log rec'), ['recover'])
        self.assertIn('--duration', self.complete('hrp-simulate run.yaml --d'))
        self.assertEqual(self.complete('hrp-simulate --dds f'), ['fast'])
        self.assertEqual(self.complete('hrp-log cat run.mcap --js'), ['--json'])


if __name__ == '__main__':
    unittest.main()
