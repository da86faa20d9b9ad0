# SPDX-License-Identifier: BSD-3-Clause
"""What an experiment is, and what comes out of one. A module of this folder lists its own in EXPERIMENTS."""
import os


class Experiment:
    """measure(run, out) does it; run is a runs.Runner, out an Outcome. cost: seconds on an idle machine with two cores,
    for the estimate of the time that is left only."""

    def __init__(self, name, title, saw, measure, group='paper', cost=5.0):
        self.name, self.title, self.saw, self.measure, self.group, self.cost = name, title, saw, measure, group, cost


class Skipped(Exception):
    """Something that the experiment needs is not on this machine; says what."""


class Outcome:
    """claims: (text, holds). numbers: (name, value with unit). figures: (caption, SVG). seen: a sentence, in parts."""

    def __init__(self):
        self.claims, self.numbers, self.figures, self.seen = [], [], [], []
        self.skipped = ''   # why it was not run
        self.log = ''       # of the server set
        self.origin = 'Runs in one process, without servers.'  # of plots and numbers
        self.held = ''      # 9/10
        self.seconds = 0.0  # of wall clock

    def claim(self, text, holds):
        self.claims.append((text, bool(holds)))

    def number(self, name, value):
        self.numbers.append((name, value))

    def figure(self, caption, svg):
        self.figures.append((caption, svg))

    def see(self, text):
        self.seen.append(text)

    def verdict(self):
        if self.skipped:
            return 'skipped'
        return 'pass' if self.claims and all(holds for _, holds in self.claims) else 'FAIL'


def upright(summary):
    return not summary['fallen'] and not summary['fault']


def tell_logs(out, summary):
    out.claim('equal logs: %s' % summary['bits'], summary['same'])
    out.log = summary['log']
    out.origin = 'Numbers and plots: run %s, last state %s; %s%s. Runs for comparison are in one process.' % (
        os.path.basename(summary['log']), summary['state_hash'], summary['bits'], '' if summary['same'] else ' DIFFER')


def tell_run(out, summary):
    """What every experiment with a walk says of it."""
    tell_logs(out, summary)
    out.number('upright to the end', 'no, falls at %.2f s' % summary['fall_time'] if summary['fallen'] else 'yes')
    out.number('largest lean of the body', '%.3f rad' % summary['largest_lean'])
    out.number('travelled', '%.2f m forward, %.2f m to the left' % tuple(summary['travelled'][:2]))
    if summary['fallen']:
        out.see('falls at %.2f s' % summary['fall_time'])
    else:
        out.see('upright, %.2f m forward, largest lean %.3f rad' % (summary['travelled'][0], summary['largest_lean']))


def tell_varied(run, out, name, text, good, words, table=False):
    """Ten more runs with random changes; at least nine must be good. good(summary), with a table good(summary, columns)."""
    held = 0
    for summary, columns in run.vary(name, text, table):
        held += bool(good(summary, columns) if table else good(summary))
    if run.runs:
        out.held = '%d/%d' % (held, run.runs)
        out.claim('%s in at least nine of ten runs with masses changed by up to 2 %% and joints by up to 0.02 rad (%d of %d)'
                  % (words, held, run.runs), held >= 0.9 * run.runs)
