#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/diagnose.sh finds what is hidden in the experiments that are shipped: shipped_experiments_test.py BUILD SOURCE."""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BUILD, SOURCE = Path(sys.argv[1]), Path(sys.argv[2])
EXPERIMENTS = SOURCE / 'models' / 'experiments'


def diagnose(out, *words):
    """What the script says, and the report."""
    ran = subprocess.run([SOURCE / 'scripts' / 'diagnose.sh', *words, '--out', out, '--quiet'], capture_output=True, text=True,
                         env={**os.environ, 'HRP_BUILD_DIR': str(BUILD)}, check=False)
    said = ran.stdout + ran.stderr
    if ran.returncode != 0:
        raise AssertionError(said)
    return said, json.loads((Path(out) / 'report.json').read_text())


def list_places(hypotheses, key=lambda h: h):
    return sorted((h['effect'], *(str(key(h)[k]) for k in ('joint', 'link', 'foot', 'sensor') if k in key(h))) for h in hypotheses)


class ShippedExperiments(unittest.TestCase):
    def check(self, name, *words):
        with tempfile.TemporaryDirectory() as out:
            said, report = diagnose(out, *words)
            self.assertIn(f'{out}/report.html', said)
            self.assertTrue((Path(out) / 'report.html').is_file())
            answer = EXPERIMENTS / 'answers' / f'{name}.json'
            self.assertIn(str(answer), said)
        hidden = json.loads(answer.read_text())['hidden']
        self.assertEqual(list_places(report['findings'], lambda h: h['where']), list_places(hidden), said)

    def test_without_arguments_the_arms_hidden_effect_is_named_and_nothing_else(self):
        self.check('arm')

    def test_the_standing_robots_hidden_effect_is_named_and_nothing_else(self):
        self.check('standing', str(EXPERIMENTS / 'standing' / 'experiment.yaml'))

    def test_each_is_under_a_megabyte_when_packed(self):
        for folder in EXPERIMENTS.glob('*/experiment.yaml'):
            packed = subprocess.run(['tar', '-C', folder.parent, '-czf', '-', '.'], capture_output=True, check=True).stdout
            self.assertLess(len(packed), 1_000_000, folder)


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
