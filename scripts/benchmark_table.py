#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_table.py FOLDER: what scripts/benchmark.sh has measured (multibody.json, step.json, server_set.txt) as tables in
Markdown."""
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys

MULTIBODY = (('forward dynamics', 'forward_dynamics', ('ours', 'mujoco', 'dart')), ('mass matrix', 'mass_matrix', ('ours', 'mujoco', 'dart')),
             ('inverse dynamics', 'inverse_dynamics', ('ours', 'mujoco', 'dart')))
STEPS = (('ours, contacts given', 'our_step', (0, 4, 8, 16, 32, 64)),
         ('ours, contacts given, margin 1 mm', 'our_quiet_step', (8, 32, 64)))
OPTIONS = ('elliptic cones, implicit', 'default', 'default, one iteration')
JOINTS = (25, 50, 100, 200)
LIMBS = ((13, 'limbs of 13 joints'), (1000, 'one limb'))
JOINT_ROWS = (('ours', 'our_joints/%d/%d'), ('MuJoCo, elliptic cones, implicit', 'mujoco_joints/%d/%d/0'), ('MuJoCo, default', 'mujoco_joints/%d/%d/1'))
PACKAGES = ('libmujoco-dev', 'libdart-dev', 'libeigen3-dev', 'cyclonedds-dev', 'libfastrtps-dev')


def read(path):
    """Name -> all repetitions, without Google Benchmark's own sums."""
    found = {}
    for each in json.loads(path.read_text())['benchmarks']:
        if each.get('run_type') == 'iteration' and not each.get('error_occurred'):
            found.setdefault(re.sub(r'/process_time$', '', each['name']), []).append(each)
    return found


def find_time(runs, name):
    """Median of processor time [us]; None: not measured on this machine."""
    scale = {'ns': 1e-3, 'us': 1.0, 'ms': 1e3}
    return statistics.median(r['cpu_time'] * scale[r['time_unit']] for r in runs[name]) if name in runs else None


def find_counter(runs, name, counter):
    return statistics.median(r[counter] for r in runs[name]) if name in runs else None


def show(value, form='%.2f'):
    return '-' if value is None else form % value


def print_row(*cells):
    print('| ' + ' | '.join(cells) + ' |')


def print_head(*cells):
    print_row(*cells)
    print_row(*['---'] * len(cells))


def print_machine():
    cpu = re.search(r'model name\s*: (.*)', pathlib.Path('/proc/cpuinfo').read_text())[1]
    print('%s, %d cores, kernel %s, load %.1f' % (cpu, os.cpu_count(), platform.release(), os.getloadavg()[0]))
    said = subprocess.run(['dpkg-query', '-W', '-f=${Package} ${Version}, ', *PACKAGES], capture_output=True, text=True).stdout
    print(said.rstrip(', ') + '\n')


def print_multibody(runs):
    print_head('Unitree G1 [us]', 'ours', 'MuJoCo', 'DART')
    for title, name, engines in MULTIBODY:
        print_row(title, *(show(find_time(runs, 'g1/%s/%s' % (name, engine))) for engine in engines))
    print()


def print_step(runs, title, name):
    print_row(title, show(find_counter(runs, name, 'contacts'), '%d'), show(find_counter(runs, name, 'solves'), '%.1f'),
              show(find_time(runs, name)))


def print_steps(runs):
    print_head('whole step [us]', 'contacts', 'solves', 'time')
    for title, kind, rows in STEPS:
        for points in rows:
            print_step(runs, title, '%s/%d' % (kind, points))
    print_row('ours, search of contacts', '', '', show(find_time(runs, 'our_search/0')))
    for i, options in enumerate(OPTIONS):
        name = 'mujoco_step/%d' % i
        print_row('MuJoCo, %s, with search' % options, show(find_counter(runs, name, 'contacts'), '%d'), '', show(find_time(runs, name)))
    print()
    print_head('1000 robots in one process, with search', 'robot steps per second of processor')
    print_row('ours', show(find_counter(runs, 'our_batch', 'robot_steps'), '%.0f'))
    for i, options in enumerate(OPTIONS):
        print_row('MuJoCo, ' + options, show(find_counter(runs, 'mujoco_batch/%d' % i, 'robot_steps'), '%.0f'))
    print()


def print_joints(runs):
    print_head('step with search against joints [us]', *('%d' % joints for joints in JOINTS))
    for limb, shape in LIMBS:
        for title, name in JOINT_ROWS:
            print_row('%s, %s' % (title, shape), *(show(find_time(runs, name % (joints, limb)), '%.1f') for joints in JOINTS))
    print()


def print_server_set(text):
    factors = {}
    for name, factor in re.findall(r'(?m)^(\S+)\s+([\d.]+) x real time', text):
        factors.setdefault(name, []).append(float(factor))
    print_head('server set, 1 kHz, log', 'x real time, median', 'all')
    for name, values in factors.items():
        print_row(name, show(statistics.median(values), '%.1f'), ', '.join('%g' % v for v in values))


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ('-h', '--help'):
        print(__doc__)
        return 0 if len(sys.argv) == 2 else 2
    folder = pathlib.Path(sys.argv[1])
    print_machine()
    print_multibody(read(folder / 'multibody.json'))
    steps = read(folder / 'step.json')
    print_steps(steps)
    print_joints(steps)
    if (folder / 'server_set.txt').exists():
        print_server_set((folder / 'server_set.txt').read_text())
    return 0


if __name__ == '__main__':
    sys.exit(main())
