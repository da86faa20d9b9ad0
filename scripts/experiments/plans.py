# SPDX-License-Identifier: BSD-3-Clause
"""Footstep plans that legs cannot walk are refused before the first step, with the step and the reason."""
import os
import re
import subprocess

from experiment import Experiment

# What is wrong with it, the plan, and what must be said.
BAD_PLANS = (
    ('too long', '{count: 3, length: 0.9}', 'step 1 (right): too long'),
    ('crossing legs', '{footsteps: [{x: 0.2, y: -0.19}, {x: 0.2, y: -0.05}]}', 'step 2 (left): crossing legs'),
    ('unknown frame', '{footsteps: [{x: 0.2, y: -0.19}, {frame: map, x: 0.2, y: 0.19}]}', "step 2 (left): unknown frame 'map'"),
    ('too wide', '{footsteps: [{y: -0.6}]}', 'step 1 (right): too wide'),
    ('turns too far', '{footsteps: [{y: -0.19, theta: 1.2}]}', 'step 1 (right): turns too far'),
    ('too high', '{footsteps: [{x: 0.2, y: -0.19, z: 0.3}]}', 'step 1 (right): too high'),
    ('same foot twice', '{footsteps: [{side: right, y: -0.19}, {side: right, y: -0.19}]}', 'step 2 (right): the same foot twice'),
)


def refused(run, out):
    said = 0
    for what, plan, words in BAD_PLANS:
        name = 'plan_' + re.sub(r'\W+', '_', what)
        text = re.sub(r'plan: .*', 'plan: ' + plan, run.text('fig9'))
        run.tell(name)
        path, log = run.write(name, text), os.path.join(run.out, name + '.mcap')
        command = [os.path.join(run.bin, 'hrp-simulate'), path, '--log', log, '--no-plot', '--quiet', '--dds', run.vendors[0]]
        done = subprocess.run(command, capture_output=True, text=True)
        if os.path.exists(log):
            os.remove(log)
        answer = [line for line in (done.stderr + done.stdout).splitlines() if words in line]
        out.number(what, answer[0].split('error: ')[-1] if answer else 'not refused as it should be')
        out.claim('%s: the run ends before its first step, and says "%s"' % (what, words), bool(answer) and done.returncode != 0)
        said += bool(answer)
    out.see('%d of %d refused with the step and the reason' % (said, len(BAD_PLANS)))


EXPERIMENTS = [Experiment('plans', 'Bad footstep plans', '', refused, 'beyond', 4.0)]
