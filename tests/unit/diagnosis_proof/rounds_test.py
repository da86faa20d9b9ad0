#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""rounds_test.py SOURCE: a dialogue with a reality refuses what it cannot use before it diagnoses, and deletes nobody's
recordings; and plays each motion as a robot would."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / 'scripts/diagnosis'))
import next_rounds  # noqa: E402
EXPERIMENT = 'robot: r.urdf\nrecordings:\n  - {file: a.csv}\n'


class Rounds(unittest.TestCase):
    def setUp(self):
        self.top = pathlib.Path(tempfile.mkdtemp(prefix='hrp_rounds_'))
        self.addCleanup(shutil.rmtree, self.top, True)
        self.given = self.top / 'experiment'
        self.given.mkdir()
        (self.given / 'experiment.yaml').write_text(EXPERIMENT)
        (self.given / 'a.csv').write_text('time\n0\n')

    def refuse(self, said, *words):
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=self.top)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(said, done.stderr)
        self.assertEqual((self.given / 'a.csv').read_text(), 'time\n0\n')

    def start(self, said, out):
        self.refuse(said, sys.executable, SOURCE / 'scripts/diagnosis/next_rounds.py', self.top / 'no_programs', self.given / 'experiment.yaml',
                    out, '1', 'true')

    def test_the_folder_of_the_experiment_is_no_place_for_its_copy(self):
        self.start('holds the experiment itself', self.top)

    def test_a_folder_of_something_else_stays(self):
        (self.top / 'out/experiment').mkdir(parents=True)
        (self.top / 'out/experiment/precious').write_text('')
        self.start('is of no earlier dialogue', self.top / 'out')
        self.assertTrue((self.top / 'out/experiment/precious').exists())

    def test_a_place_that_is_no_folder_is_refused(self):
        (self.top / 'file').write_text('')
        self.start('file', self.top / 'file')

    def test_a_list_in_brackets_gets_no_lines(self):
        (self.given / 'experiment.yaml').write_text('robot: r.urdf\nrecordings: [{file: a.csv}]\n')
        self.start("expected one recording a line", self.top / 'out')

    def test_words_of_the_script_are_checked_before_it_builds(self):
        script, experiment = SOURCE / 'scripts/diagnose.sh', self.given / 'experiment.yaml'
        for said, words in (("--rounds is 'x'", ['--rounds', 'x', '--against', 'true']), ("--rounds is '0'", ['--rounds', '0', '--against', 'true']),
                            ('no program nowhere', ['--rounds', '1', '--against', 'nowhere --at all']), ('no file none.yaml', ['--rounds', '1', '--against', 'none.yaml']),
                            ("--wait is 'nan'", ['--resimulate', 'servers', '--controller', 'c', '--wait', 'nan']), ('--out needs a value', ['--out'])):
            self.refuse(said, 'bash', script, experiment, *words)

    def play(self, motion):
        text = next_rounds.make_scenario('robot: r.urdf\nseed: 7\n', self.top, self.top / f'{motion}.commands.csv', 6.0)
        return dict(line.split(': ', 1) for line in text.strip().splitlines())

    def test_each_played_motion_has_noise_of_its_own(self):
        first, second = self.play('round_1_train_1')['seed'], self.play('round_1_validate_1')['seed']
        self.assertNotEqual(first, second)
        self.assertEqual(first, self.play('round_1_train_1')['seed'])

    def test_a_simulated_drive_is_late_by_less_than_two_implementations_differ(self):
        # Half a step, at the speed of 1 rad/s, against the noise of a good encoder (3e-4 rad): a fifth of it in quadrature is 2 %.
        step = float(self.play('round_1_train_1')['steps'].split('time_step: ')[1].split(',')[0])
        self.assertLess(0.5 * step * 1.0, 0.2 * 3e-4)


if __name__ == '__main__':
    unittest.main()
