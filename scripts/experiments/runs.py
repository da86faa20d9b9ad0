# SPDX-License-Identifier: BSD-3-Clause
"""Runs of scenarios: through the server set, and without a bus where many are needed; numbers from their data."""
import csv
import json
import math
import os
import re
import subprocess

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
FOLDER = os.path.join(ROOT, 'models', 'scenarios', 'paper_a')


class Runner:
    def __init__(self, bin_folder, out, dds):
        self.bin, self.out, self.dds = bin_folder, out, dds
        os.makedirs(out, exist_ok=True)

    def text(self, name):
        """A scenario that can be written anywhere."""
        with open(os.path.join(FOLDER, name + '.yaml')) as file:
            text = file.read()
        return re.sub(r'(?m)^robot: (\S+)', lambda m: 'robot: ' + os.path.normpath(os.path.join(FOLDER, m[1])), text)

    def write(self, name, text):
        path = os.path.join(self.out, name + '.yaml')
        with open(path, 'w') as file:
            file.write(text)
        return path

    def serve(self, name, text):
        """Through the server set. Returns the log and the hash of the last state."""
        path, log = self.write(name, text), os.path.join(self.out, name + '.mcap')
        done = subprocess.run([self.bin + '/hrp-simulate', path, '--log', log, '--no-plot', '--quiet', '--dds', self.dds],
                              capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError('%s: %s' % (name, done.stderr.strip() or done.stdout.strip()))
        found = re.search(r'state hash\s+(\w+)', done.stdout + done.stderr)
        return log, found[1] if found else ''

    def trial(self, name, text, table=False):
        """Without bus and log. Returns the summary and, on request, the columns at every physics step."""
        path, csv_path = self.write(name, text), os.path.join(self.out, name + '.csv')
        done = subprocess.run([self.bin + '/hrp-trial', path] + (['--csv', csv_path] if table else []),
                              capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError('%s: %s' % (name, done.stderr.strip()))
        columns = None
        if table:
            with open(csv_path) as file:
                rows = list(csv.reader(file))
            columns = {key: [float(row[i]) for row in rows[1:]] for i, key in enumerate(rows[0])}
            os.remove(csv_path)
        return json.loads(done.stdout), columns

    def both(self, name, text):
        """Through the server set, and once more step by step for the table. Equal hashes prove that it is the same run.
        A run that falls goes on in the server set, so its hash cannot be compared."""
        log, hash_served = self.serve(name, text)
        summary, columns = self.trial(name, text, table=True)
        summary['log'] = log
        summary['same'] = None if summary['fallen'] else hash_served == summary['state_hash']
        return summary, columns

    def vary(self, name, text, runs):
        """Runs with masses of all links within 2 % and initial joint angles within 0.02 rad at random."""
        results = []
        for seed in range(1, runs + 1):
            changed = text + 'variation: {mass: 0.02, pose: 0.02, seed: %d}\n' % seed
            results.append(self.trial(name + '_varied', changed)[0])
        return results

    def plot(self, name, title, x_label, y_label, x, series):
        """SVG text of columns, {label: values}."""
        table, out = os.path.join(self.out, name + '_plot.csv'), os.path.join(self.out, name + '.svg')
        with open(table, 'w') as file:
            file.write('x,' + ','.join(series) + '\n')
            for i, value in enumerate(x):
                file.write('%.6g,' % value + ','.join('%.6g' % s[i] for s in series.values()) + '\n')
        subprocess.run([self.bin + '/hrp-plot', table, '--out', out, '--title', title, '--x', x_label, '--y', y_label],
                       check=True)
        os.remove(table)
        with open(out) as file:
            return file.read()


def high_pass(x, rate, cutoff):
    for _ in range(2):
        a, y = 1.0 / (1.0 + 2.0 * math.pi * cutoff / rate), [0.0] * len(x)
        for i in range(1, len(x)):
            y[i] = a * (y[i - 1] + x[i] - x[i - 1])
        x = y
    return x


def low_pass(x, rate, cutoff):
    for _ in range(2):
        a, y = 1.0 - math.exp(-2.0 * math.pi * cutoff / rate), [x[0]] * len(x)
        for i in range(1, len(x)):
            y[i] = y[i - 1] + a * (x[i] - y[i - 1])
        x = y
    return x


def rms(x, chosen):
    return math.sqrt(sum(x[i] * x[i] for i in chosen) / max(1, len(chosen)))


def median(x):
    x = sorted(x)
    return x[len(x) // 2] if len(x) % 2 else 0.5 * (x[len(x) // 2 - 1] + x[len(x) // 2])


def solve(A, b):
    """Gauss with pivoting; small systems only."""
    n = len(b)
    M = [list(row) + [b[i]] for i, row in enumerate(A)]
    for i in range(n):
        p = max(range(i, n), key=lambda k: abs(M[k][i]))
        M[i], M[p] = M[p], M[i]
        for k in range(n):
            if k != i:
                f = M[k][i] / M[i][i]
                M[k] = [a - f * c for a, c in zip(M[k], M[i])]
    return [M[i][n] / M[i][i] for i in range(n)]


def least_squares(columns, y):
    A = [[sum(a * b for a, b in zip(p, q)) for q in columns] for p in columns]
    return solve(A, [sum(a * b for a, b in zip(p, y)) for p in columns])
