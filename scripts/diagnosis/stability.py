#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Does the verdict stay when the recordings change in what must not matter? Makes N concealed cases with hrp-make-cases
and asks hrp-diagnose about each as it is, with other noise, with the first half of every recording, with recordings in
another order, with renamed joints, and on a clock that started at another time. Compared are the verdict and the effects
with their places. Prints a line a case; exit status 1 when an answer changed.

    scripts/diagnosis/stability.py [--cases 4] [--seed 1] [--duration 5] [--family joint] [--out out/stability] [--jobs 2]
"""
import argparse
import csv
import json
import math
import pathlib
import random
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHIFT = 1234.5  # [s] what a robot that has run for a while would stamp its first sample with


def read_rows(path):
    with open(path) as file:
        return list(csv.reader(file))


def write_rows(path, rows):
    with open(path, 'w') as file:
        file.writelines(','.join(row) + '\n' for row in rows)


def change_tables(folder, change):
    for path in sorted(folder.glob('*.csv')):
        write_rows(path, change(path, read_rows(path)))


def change_text(folder, name, change):
    (folder / name).write_text(change((folder / name).read_text()))


def halve(folder):
    """The first half of every recording: half as much to tell from."""
    def cut(_, rows):
        begin, end = float(rows[1][0]), float(rows[-1][0])
        return rows[:1] + [row for row in rows[1:] if float(row[0]) <= 0.5 * (begin + end)]
    change_tables(folder, cut)


def shift_time(folder):
    change_tables(folder, lambda _, rows: rows[:1] + [['%.6f' % (float(r[0]) + SHIFT)] + r[1:] for r in rows[1:]])


def reorder(folder):
    """Recordings last to first; each keeps its role."""
    def turn(text):
        head, entries = text.split('recordings:\n')
        return head + 'recordings:\n' + '\n'.join(reversed(entries.strip('\n').split('\n'))) + '\n'
    change_text(folder, 'experiment.yaml', turn)


def list_joints(folder):
    """Joints that the tables speak of, in the robot's order."""
    seen = {name.split('/')[2] for name in read_rows(sorted(folder.glob('*.csv'))[0])[0] if name.startswith('/joint_')}
    return [j for j in re.findall(r'<joint name="([^"]+)"', (folder / 'robot.urdf').read_text()) if j in seen]


def rename(folder):
    """Other names, whose alphabetical order is turned round. Returns {new name: old name}."""
    joints = list_joints(folder)
    new = {old: 'axis_%02d' % (len(joints) - i) for i, old in enumerate(joints)}

    def in_urdf(text):
        return re.sub(r'(<(?:joint name|mimic joint)=")([^"]+)"', lambda m: m[1] + new.get(m[2], m[2]) + '"', text)

    def in_yaml(text):
        return re.sub(r'(?m)^(    )([^:\s]+):', lambda m: m[1] + new.get(m[2], m[2]) + ':', text)

    def in_head(_, rows):
        return [[re.sub(r'^(/joint_[^/]+/)([^/]+)', lambda m: m[1] + new.get(m[2], m[2]), name) for name in rows[0]]] + rows[1:]
    change_text(folder, 'robot.urdf', in_urdf)
    change_text(folder, 'experiment.yaml', in_yaml)
    change_tables(folder, in_head)
    return {v: k for k, v in new.items()}


def find_spread(cells):
    """Root mean square of the differences of two columns; cells may be empty."""
    squares = [(float(a) - float(b)) ** 2 for a, b in cells if a and b]
    return math.sqrt(sum(squares) / len(squares)) if squares else 0.0


def make_noise_anew(folder, clean, seed):
    """The same motion read with other noise: of each column as much as tells the case from its twin without noise."""
    def draw(path, rows):
        source = random.Random('%s %d' % (path.name, seed))
        bare = read_rows(clean / path.name)
        sigma = {c: find_spread((a[c], b[c]) for a, b in zip(rows[1:], bare[1:])) for c in range(1, len(rows[0]))}
        return rows[:1] + [b[:1] + ['%.9g' % (float(b[c]) + source.gauss(0, s)) if b[c] and s > 0 else b[c]
                                    for c, s in sigma.items()] for b in bare[1:]]
    change_tables(folder, draw)


VARIANTS = {'other noise': None, 'first halves': halve, 'other order': reorder, 'other names': rename, 'other clock': shift_time}


def ask(tool, folder, jobs):
    run = subprocess.run([str(tool), str(folder / 'experiment.yaml'), '--out', str(folder / 'answer'), '--jobs', str(jobs), '--quiet'],
                         capture_output=True, text=True)
    if run.returncode:
        return ('status %d' % run.returncode, (run.stderr.strip() or run.stdout.strip(),))
    report = json.loads((folder / 'answer' / 'report.json').read_text())
    places = sorted((f['effect'], ' '.join(sorted(map(str, f['where'].values())))) for f in report['findings'])
    return (report['verdict'], tuple(places))


def translate(answer, names):
    def place(text):
        return re.sub(r'axis_\d\d', lambda m: names.get(m[0], m[0]), text)
    return (answer[0], tuple(sorted((effect, place(where)) for effect, where in answer[1])))


def make_variant(case, name, clean, folder, seed):
    """Copies the case and changes it. Returns what its new names were called before."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(case, folder)
    if name == 'other noise':
        make_noise_anew(folder, clean, seed)
        return {}
    return VARIANTS[name](folder) or {}


def spell(answer):
    return answer[0] + (': ' + ', '.join('%s at %s' % tuple(f) for f in answer[1]) if answer[1] else '')


def examine(tool, case, clean, out, seed, jobs):
    """{variant: answer} of one case, the case itself under 'as it is'."""
    folder = out / case.name / 'as_it_is'
    shutil.copytree(case, folder)
    answers = {'as it is': ask(tool, folder, jobs)}
    for name in VARIANTS:
        if name == 'other noise' and clean is None:
            continue
        folder = out / case.name / name.replace(' ', '_')
        names = make_variant(case, name, clean, folder, seed)
        answers[name] = translate(ask(tool, folder, jobs), names)
    return answers


def read_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--cases', type=int, default=4)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--duration', type=float, default=5.0, help='[s] of the longest recordings')
    parser.add_argument('--family', default='joint')
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--bin', type=pathlib.Path, default=ROOT / 'build' / 'bin')
    parser.add_argument('--out', type=pathlib.Path, default=ROOT / 'out' / 'stability')
    return parser.parse_args()


def main():
    options = read_options()
    out = options.out / ('seed-%d-%s' % (options.seed, options.family.replace(',', '-')))
    shutil.rmtree(out, ignore_errors=True)
    for name, more in (('made', []), ('clean', ['--no-noise'])):
        subprocess.run([str(options.bin / 'hrp-make-cases'), '--out', str(out / name), '--cases', str(options.cases), '--seed',
                        str(options.seed), '--duration', str(options.duration), '--family', options.family] + more,
                       check=True, capture_output=True)
    same = total = 0
    for case in sorted((out / 'made' / 'cases').iterdir()):
        answers = examine(options.bin / 'hrp-diagnose', case, out / 'clean' / 'cases' / case.name, out / 'asked', options.seed, options.jobs)
        hidden = json.loads((out / 'made' / 'truths' / (case.name + '.json')).read_text())['hidden']
        print('%s: hidden %s; %s' % (case.name, ' + '.join(h['effect'] for h in hidden) or 'nothing', spell(answers['as it is'])))
        for name, answer in list(answers.items())[1:]:
            total += 1
            same += answer == answers['as it is']
            if answer != answers['as it is']:
                print('    with %s: %s' % (name, spell(answer)))
        sys.stdout.flush()
    print('%d of %d changed recordings got the same answer' % (same, total))
    return 0 if same == total else 1


if __name__ == '__main__':
    sys.exit(main())
