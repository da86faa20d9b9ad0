# SPDX-License-Identifier: BSD-3-Clause
"""One run of a sweep, on whatever machine: a scenario in, what happened out; or one case of a blind trial: an experiment in, an
answer out. Knows nothing of the other modules, so that it
can be sent to the workers of a cluster."""
import json
import os
import signal
import subprocess
import tempfile
import time

# Of a run whose process ends by a signal: somebody else's (the kernel out of memory, an operator), or its own crash.
ATTEMPTS_WHEN_KILLED, ATTEMPTS_WHEN_CRASHED = 30, 2
TOO_LONG = 124  # as the program `timeout` ends
OTHERS_SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)


class Killed(Exception):
    """The process of the run was ended by a signal: nothing is known of the run."""

    def __init__(self, number):
        super().__init__('ended by signal %d' % number)
        self.attempts = ATTEMPTS_WHEN_KILLED if number in OTHERS_SIGNALS else ATTEMPTS_WHEN_CRASHED


def attempt(program, scenario, limit):
    with tempfile.TemporaryDirectory(prefix='hrp-sweep-') as folder:
        path = os.path.join(folder, 'scenario.yaml')
        with open(path, 'w') as file:
            json.dump(scenario, file)  # JSON is YAML
        try:
            done = subprocess.run([program, path], capture_output=True, text=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return {'status': 'too_long', 'fault': 'not done in %g s' % limit}
    if done.returncode < 0:
        raise Killed(-done.returncode)
    if done.returncode > 0:
        return {'status': 'refused', 'fault': done.stderr.strip().replace(path, 'scenario')}
    said = json.loads(done.stdout)
    result = {'status': 'fault' if said['fault'] else 'ok'}
    for key in ('fallen', 'fall_time', 'duration', 'largest_lean', 'turned', 'state_hash', 'fault'):
        result[key] = said[key]
    result.update(zip(('travelled_x', 'travelled_y', 'travelled_z'), said['travelled']))
    result['landings'] = sum(said['landings'])
    return result


def answer(program, case, limit):
    """The diagnosis of one case, in the case's folder of answers; run.json there says that it is done."""
    os.makedirs(case['answer'], exist_ok=True)
    begin = time.time()
    with open(os.path.join(case['answer'], 'terminal.txt'), 'w') as terminal:
        try:
            status = subprocess.run([program, case['experiment'], '--out', case['answer'], '--jobs', '1'], stdout=terminal,
                                    stderr=subprocess.STDOUT, timeout=limit).returncode
        except subprocess.TimeoutExpired:
            status = TOO_LONG
    if -status in OTHERS_SIGNALS:
        raise Killed(-status)
    result = {'status': 128 - status if status < 0 else status, 'seconds': round(time.time() - begin, 1)}
    path = os.path.join(case['answer'], 'run.json')
    with open(path + '.new', 'w') as file:
        json.dump(result, file)
    os.replace(path + '.new', path)
    return result


def do_run(key, scenario, program, limit):
    begin, result, deaths = time.time(), None, 0
    while result is None:
        try:
            result = answer(program, scenario, limit) if 'answer' in scenario else attempt(program, scenario, limit)
        except Killed as reason:
            deaths += 1
            if deaths >= reason.attempts:
                result = {'status': 'killed', 'fault': str(reason)}
    return {'key': key, 'result': result, 'seconds': time.time() - begin}
