# SPDX-License-Identifier: BSD-3-Clause
"""Runs of scenarios: through the server set, and without a bus where many are needed; plots and pictures of them."""
import csv
import itertools
import json
import os
import re
import subprocess
import threading

from experiment import Skipped

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
FOLDER = os.path.join(ROOT, 'models', 'scenarios', 'paper_a')
VENDORS = {'cyclone': 'Cyclone DDS', 'fast': 'Fast DDS'}
# A server set uses every core by itself; trials beside it fill the gaps. Two sets at once would only wait for each other.
one_server_set = threading.Lock()


class Runner:
    """Of one experiment: its files are in a folder of its own."""

    def __init__(self, bin_folder, out, vendors, runs, tell=lambda what: None, short=False):
        self.bin, self.out, self.vendors, self.runs, self.tell = bin_folder, out, vendors, runs, tell
        self.short = short  # as little as shows the claim, for tests
        os.makedirs(out, exist_ok=True)

    def text(self, name):
        """A scenario that can be written anywhere."""
        with open(os.path.join(FOLDER, name + '.yaml')) as file:
            text = file.read()
        robot = os.path.normpath(os.path.join(FOLDER, re.search(r'(?m)^robot: (\S+)', text)[1]))
        if not os.path.exists(robot):
            raise Skipped('%s needs a robot that is not here: %s' % (name, os.path.relpath(robot, ROOT)))
        return re.sub(r'(?m)^robot: .*', 'robot: ' + robot, text)

    def write(self, name, text):
        path = os.path.join(self.out, name + '.yaml')
        with open(path, 'w') as file:
            file.write(text)
        return path

    def call(self, name, words):
        done = subprocess.run([os.path.join(self.bin, words[0])] + words[1:], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError('%s: %s' % (name, done.stderr.strip() or done.stdout.strip()))
        return done.stdout

    def serve(self, name, text, dds, log):
        """Through the server set. Returns the hash of the last state and those of all payloads by topic."""
        path = self.write(name, text)
        self.tell('%s through the server set, %s' % (name, VENDORS[dds]))
        with one_server_set:
            said = self.call(name, ['hrp-simulate', path, '--log', log, '--force', '--no-plot', '--quiet', '--dds', dds])
        found = re.search(r'state hash\s+(\w+)', said)
        return found[1] if found else '', self.call(name, ['hrp-log', 'hash', log])

    def trial(self, name, text, table=False, to_the_end=False, keep=1):
        """Without bus and log. Returns the summary and, on request, the columns at every physics step, or every keep-th."""
        path, csv_path = self.write(name, text), os.path.join(self.out, name + '.csv')
        self.tell(name)
        words = ['hrp-trial', path] + (['--csv', csv_path] if table else []) + (['--to-the-end'] if to_the_end else [])
        summary, columns = json.loads(self.call(name, words)), None
        if table:
            with open(csv_path) as file:
                rows = csv.reader(file)
                names = next(rows)
                kept = itertools.islice(rows, keep - 1, None, keep)
                columns = dict(zip(names, map(list, zip(*(map(float, row) for row in kept)))))
            os.remove(csv_path)
        return summary, columns

    def both(self, name, text):
        """Twice through the server set on the first vendor and once on every other, all logs compared by the hash of all
        payloads, and once more step by step without a bus for the table: equal hashes prove that it is the same run."""
        log = os.path.join(self.out, name + '.mcap')
        state, payloads = self.serve(name, text, self.vendors[0], log)
        same, again = True, os.path.join(self.out, name + '_again.mcap')
        for dds in self.vendors:
            same = self.serve(name, text, dds, again)[1] == payloads and same
            os.remove(again)
        summary, columns = self.trial(name, text, table=True, to_the_end=True)
        summary['log'] = log
        summary['same'] = same and bool(state) and state == summary['state_hash']
        summary['bits'] = 'server set twice on %s%s, and one process' % (
            VENDORS[self.vendors[0]], ''.join(', on ' + VENDORS[v] for v in self.vendors[1:]))
        return summary, columns

    def vary(self, name, text, table=False):
        """(summary, columns) of runs with masses of all links within 2 % and initial joint angles within 0.02 rad at random."""
        for seed in range(1, self.runs + 1):
            changed = text + 'variation: {mass: 0.02, pose: 0.02, seed: %d}\n' % seed
            yield self.trial('%s_varied_%d' % (name, seed), changed, table)

    def plot(self, name, title, x_label, y_label, x, series):
        """SVG text of columns, {label: values}."""
        table, out = os.path.join(self.out, name + '_plot.csv'), os.path.join(self.out, name + '.svg')
        with open(table, 'w') as file:
            file.write('x,' + ','.join(series) + '\n')
            for row in zip(x, *series.values()):
                file.write(','.join('%.6g' % value for value in row) + '\n')
        self.call(name, ['hrp-plot', table, '--out', out, '--title', title, '--x', x_label, '--y', y_label])
        os.remove(table)
        return self.read(out)

    def pictures(self, name, log, begin, end, options=()):
        """SVG text: the robot at eight moments."""
        out = os.path.join(self.out, name + '_pictures.svg')
        self.call(name, ['hrp-log', 'pictures', log, '--out', out, '--from', '%g' % begin, '--to', '%g' % end] + list(options))
        return self.read(out)

    @staticmethod
    def read(path):
        with open(path) as file:
            return file.read()
