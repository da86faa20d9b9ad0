#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""sweep_files_test.py SOURCE: a sweep that cannot be meant is refused before the first run, with file, line, key and value."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / 'scripts/sweep'))
import plan  # noqa: E402
import table  # noqa: E402

SCENARIO = 'scenario: scenario.yaml\n'
# What a file says, and what is said of it.
REFUSED = {
    '': 'is no mapping',
    '- a\n': 'is no mapping',
    'seeds: 3\n': 'has no key scenario',
    'scenario: none.yaml\n': 'none.yaml: No such file',
    'scenario: [3]\n': r':1: scenario: is \[3\], expected the name of a file',
    'scenario: words.yaml\n': 'words.yaml: is no mapping',
    SCENARIO + 'seads: 3\n': ':2: seads: is 3, expected one of the keys',
    SCENARIO + 'seeds: 2\nseeds: 3\n': ":3:1: the key 'seeds' is there twice",
    SCENARIO + 'seeds: many\n': ":2: seeds: is 'many', expected a number of seeds",
    SCENARIO + 'seeds: true\n': ':2: seeds: is True',
    SCENARIO + 'seeds: 0\n': ':2: seeds: is 0',
    SCENARIO + 'seeds: []\n': r':2: seeds: is \[\]',
    SCENARIO + 'seeds: 1000000000000\n': ':2: seeds: is 1000000000000, expected a number of seeds from 1 to 100000',
    SCENARIO + 'seeds: 1000\nparameters: {a: {from: 0, to: 1, count: 1000}}\n': 'makes 1000000 runs, expected at most 100000',
    SCENARIO + 'duration: long\n': ":2: duration: is 'long', expected seconds",
    SCENARIO + 'robots: []\n': r':2: robots: is \[\]',
    SCENARIO + 'controllers: [a]\n': r":2: controllers: is \['a'\]",
    SCENARIO + 'controllers:\n  a: 3\n': ':3: controllers.a: is 3, expected keys',
    SCENARIO + 'controllers: {a: {type: hold}}\n': "scenario.yaml:2: controller: is 'hold', expected a section",
    SCENARIO + 'parameters: 3\n': ':2: parameters: is 3',
    SCENARIO + 'parameters:\n  a.b: {from: 0, to: 1, count: 1}\n': ':3: parameters.a.b: is 1, expected a count from 2',
    SCENARIO + 'parameters:\n  a.b: {from: x, to: 1, count: 3}\n': ':3: parameters.a.b: .* expected numbers after from and to',
    SCENARIO + 'parameters:\n  a.b: {uniform: 3}\n': ':3: parameters.a.b: ',
    SCENARIO + 'parameters:\n  a.b: {normal: [.nan, 1]}\n': ':3: parameters.a.b: ',
    SCENARIO + 'parameters:\n  a.b: []\n': ':3: parameters.a.b: ',
    SCENARIO + 'parameters: {a..b: [1]}\n': 'a path of keys',
    SCENARIO + 'parameters: {robot.x: [1]}\n': "scenario.yaml:1: robot: is 'r.urdf', expected a section, as the sweep sets robot.x",
    SCENARIO + 'parameters: &a {b: *a}\n': ':2:.* recursive',
    SCENARIO + 'parameters: ' + '[' * 5000 + ']' * 5000 + '\n': 'nested too deeply',
    SCENARIO + 'seeds: !!set {a, b}\n': ':2:8: could not determine a constructor',
}


class SweepFiles(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='hrp_sweep_files_'))
        self.addCleanup(shutil.rmtree, self.folder, True)
        (self.folder / 'scenario.yaml').write_text('robot: r.urdf\ncontroller: hold\n')
        (self.folder / 'words.yaml').write_text('words\n')
        self.sweep = self.folder / 'sweep.yaml'

    def make_runs(self):
        return plan.make_runs(plan.load(str(self.sweep)), str(self.sweep))

    def test_what_cannot_be_meant_is_refused_by_name(self):
        for text, said in REFUSED.items():
            with self.subTest(text=text[:80]):
                self.sweep.write_text(text)
                with self.assertRaisesRegex(plan.BadSweep, said):
                    self.make_runs()

    def test_bytes_that_are_no_text_are_refused(self):
        self.sweep.write_bytes(SCENARIO.encode() + b'duration: \xe9\n')
        with self.assertRaisesRegex(plan.BadSweep, 'is no UTF-8 text: byte 34 is 0xe9'):
            self.make_runs()

    def test_numbers_and_names_are_read_as_a_scenario_reads_them(self):
        self.sweep.write_text(SCENARIO + 'parameters: {gap: [1e-3], on: [2], made: [2026-11-28]}\n')
        self.assertEqual(self.make_runs()[0]['columns'], {'scenario': 'scenario.yaml', 'gap': 1e-3, 'on': 2, 'made': '2026-11-28'})

    def test_swept_files_lie_beside_the_sweep(self):
        (self.folder / 'a.csv').write_text('time\n')
        self.sweep.write_text(SCENARIO + 'parameters: {motion: [a.csv, b.csv]}\n')
        runs = self.make_runs()
        self.assertEqual([run['columns']['motion'] for run in runs], ['a.csv', 'b.csv'])
        self.assertEqual([run['scenario']['motion'] for run in runs], [str(self.folder / 'a.csv'), 'b.csv'])

    def test_a_run_with_another_robot_in_the_same_file_is_another_run(self):
        self.sweep.write_text(SCENARIO)
        keys = []
        for robot in ('<robot/>', '<robot name="b"/>', '<robot/>'):
            (self.folder / 'r.urdf').write_text(robot)
            plan.hash_file.cache_clear()  # as in another process
            keys.append(self.make_runs()[0]['key'])
        self.assertNotEqual(keys[0], keys[1])
        self.assertEqual(keys[0], keys[2])

    def test_runs_of_another_program_are_other_runs(self):
        self.sweep.write_text(SCENARIO + 'seeds: 2\n')
        program = self.folder / 'hrp-trial'
        keys = []
        for content in (b'one', b'two', b'one'):
            program.write_bytes(content)
            plan.hash_file.cache_clear()  # as in another process
            keys.append([run['key'] for run in plan.make_runs(plan.load(str(self.sweep)), str(self.sweep), str(program))])
        self.assertFalse(set(keys[0]) & set(keys[1]))
        self.assertEqual(keys[0], keys[2])

    def test_each_file_is_read_once_for_all_runs(self):
        (self.folder / 'r.urdf').write_text('<robot/>')
        self.sweep.write_text(SCENARIO + 'seeds: 50\n')
        plan.hash_file.cache_clear()
        self.assertEqual(len(self.make_runs()), 50)
        self.assertEqual(plan.hash_file.cache_info().misses, 1)

    def test_what_was_refused_or_too_long_is_done_again(self):
        lines = [{'key': status, 'result': {'status': status}} for status in ('ok', 'fault', 'refused', 'too_long', 'killed')]
        (self.folder / 'out').mkdir()
        (self.folder / 'out/results.jsonl').write_text(''.join(json.dumps(line) + '\n' for line in lines))
        journal = table.Journal(str(self.folder / 'out'))
        self.addCleanup(journal.close)
        self.assertEqual(set(journal.done), {'ok', 'fault'})

    def test_the_program_ends_with_status_2(self):
        self.sweep.write_text(SCENARIO)
        (self.folder / 'junk').mkdir()
        (self.folder / 'junk/results.jsonl').write_text('[1]\n')
        for words, said in ((['--jobs', '0'], '0 is not above zero'), (['--limit', 'nan'], 'nan is not above zero'),
                            (['--out', str(self.sweep)], 'sweep.yaml: File exists'), (['--out', str(self.folder / 'junk')], 'results.jsonl:1: is no result')):
            done = subprocess.run([sys.executable, SOURCE / 'scripts/sweep/main.py', self.sweep, '--bin', self.folder, *words],
                                  capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)


if __name__ == '__main__':
    unittest.main()
