# SPDX-License-Identifier: BSD-3-Clause
"""Runs a sweep, keeps what is done, writes the table and the page."""
import argparse
import math
import os
import sys
import time

import page
import plan
import table
import workers
from sweep_yaml import BadSweep

PROGRAM = 'hrp-trial'
SAVE_PERIOD = 10.0  # [s] between tables while runs go on


def print_duration(seconds):
    minutes, seconds = divmod(round(seconds), 60)
    return '%d:%02d:%02d' % (minutes // 60, minutes % 60, seconds)


class Progress:
    """One line on a terminal, else a line now and then."""

    def __init__(self, total):
        self.total, self.done, self.begin, self.live, self.said = total, 0, time.time(), sys.stdout.isatty(), 0.0

    def add(self):
        self.done += 1
        now = time.time()
        if self.done < self.total and now - self.said < (0.2 if self.live else 10.0):
            return
        self.said = now
        left = (now - self.begin) * (self.total - self.done) / self.done
        print('%s[%d/%d] %s, about %s left' % ('\r\033[K' if self.live else '', self.done, self.total,
                                               print_duration(now - self.begin), print_duration(left)),
              end='' if self.live and self.done < self.total else '\n', flush=True)


def save(options, runs, journal, words):
    rows = table.make_rows(runs, journal.done)
    if rows:
        table.write_whole(os.path.join(options.out, 'table.csv'), table.make_csv(runs, rows))
        table.write_whole(os.path.join(options.out, 'report.html'),
                          page.make_page(os.path.basename(options.sweep), rows, list(runs[0]['columns']), words))


def do_left(options, left, program):
    """Entries as they come."""
    path = os.path.abspath(os.path.join(options.bin, program))
    if not options.cluster:
        return workers.do_here(left, path, options.limit, options.jobs)
    if not workers.has_dask():
        sys.exit('sweep.sh: --cluster needs Dask: apt-get install python3-distributed')
    return workers.do_on_cluster(left, path, options.limit, options.jobs, options.cluster)


def do_all(options, runs, journal):
    different = {run['key']: run for run in runs}
    left = [run for key, run in different.items() if key not in journal.done]
    print('%d runs, %d of them different, %d done before' % (len(runs), len(different), len(different) - len(left)), flush=True)
    progress, saved = Progress(len(left)), time.time()
    for entry in do_left(options, left, PROGRAM):
        journal.add(entry)
        progress.add()
        if time.time() - saved > SAVE_PERIOD:
            save(options, runs, journal, 'It goes on.')
            saved = time.time()


def positive(kind):
    """A type of argparse: a finite number above zero."""
    def read(word):
        number = kind(word)
        if not 0 < number < math.inf:
            raise argparse.ArgumentTypeError('%s is not above zero' % word)
        return number
    read.__name__ = 'number'  # of argparse's own refusals
    return read


def make_parser(name, description):
    """What all that is done in many runs can be told."""
    parser = argparse.ArgumentParser(prog=name, description=description)
    parser.add_argument('--bin', required=True)
    parser.add_argument('--out')
    parser.add_argument('--jobs', type=positive(int), default=workers.count_cores())
    parser.add_argument('--cluster', default='')
    parser.add_argument('--limit', type=positive(float), default=600.0)
    return parser


def parse(words):
    parser = make_parser('sweep.sh', __doc__)
    parser.add_argument('sweep')
    options = parser.parse_args(words)
    options.out = options.out or os.path.join('logs', os.path.splitext(os.path.basename(options.sweep))[0])
    return options


def report(options, runs, journal, begin):
    """Table, page and a summary; the number of runs that failed."""
    seconds = sum(entry['seconds'] for entry in journal.done.values())
    words = '%s of one core, %d jobs.' % (print_duration(seconds), options.jobs)
    save(options, runs, journal, words)
    rows = table.make_rows(runs, journal.done)
    bad = [row for row in rows if row['status'] != 'ok']
    print('%d of %d runs in %s: %d stand, %d fall, %d failed' % (len(rows), len(runs), print_duration(time.time() - begin),
          sum(map(page.stands, rows)), sum(row['status'] == 'ok' and row['fallen'] for row in rows), len(bad)))
    for row in bad[:3]:
        print('  run %d %s: %s' % (row['run'], row['status'], row['fault']))
    print('table %s\npage  %s' % (os.path.join(options.out, 'table.csv'), os.path.join(options.out, 'report.html')))
    return len(bad)


def sweep(options):
    program = os.path.join(options.bin, PROGRAM)
    runs = plan.make_runs(plan.load(options.sweep), options.sweep, program if os.path.isfile(program) else '')
    try:
        journal = table.Journal(options.out)
    except OSError as error:
        raise BadSweep('%s: %s' % (error.filename, error.strerror)) from None
    begin, status = time.time(), 0
    try:
        do_all(options, runs, journal)
    except KeyboardInterrupt:
        print('\nstopped; the same command goes on from here')
        status = 130
    journal.close()
    bad = report(options, runs, journal, begin)
    return status or (1 if bad else 0)


def main():
    options = parse(sys.argv[1:])
    try:
        return sweep(options)
    except BadSweep as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print('sweep.sh: %s' % error, file=sys.stderr)
        return 1


if __name__ == '__main__':
    sys.exit(main())
