# SPDX-License-Identifier: BSD-3-Clause
"""answers.py --bin BIN --out TRIAL: asks hrp-diagnose for each case of a blind trial, with the workers of a sweep. Cases lie in
TRIAL/cases, answers go to TRIAL/answers; a case that has its answer is not asked again."""
import os
import sys

import main


def find_cases(trial):
    names = sorted(entry.name for entry in os.scandir(os.path.join(trial, 'cases')) if entry.is_dir())
    return [{'key': name, 'scenario': {'experiment': os.path.abspath(os.path.join(trial, 'cases', name, 'experiment.yaml')),
                                       'answer': os.path.abspath(os.path.join(trial, 'answers', name))}} for name in names]


def is_done(case):
    return os.path.exists(os.path.join(case['scenario']['answer'], 'run.json'))


def answer_all(options):
    cases = find_cases(options.out)
    left = [case for case in cases if not is_done(case)]
    print('%d cases, %d answered before' % (len(cases), len(cases) - len(left)), flush=True)
    progress, killed = main.Progress(len(left)), 0
    for entry in main.do_left(options, left, 'hrp-diagnose'):
        killed += entry['result']['status'] == 'killed'
        progress.add()
    return 1 if killed else 0


if __name__ == '__main__':
    try:
        sys.exit(answer_all(main.make_parser('answers.py', __doc__).parse_args()))
    except KeyboardInterrupt:
        sys.exit('stopped; the same command goes on from here')
