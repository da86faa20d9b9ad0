# SPDX-License-Identifier: BSD-3-Clause
"""Runs experiments, judges them, writes the report."""
import argparse
import concurrent.futures
import importlib
import os
import subprocess
import sys
import time

from experiment import Outcome, Skipped
from progress import Progress, print_duration
from report import make_page, make_table
from runs import ROOT, VENDORS, Runner

# In the order of the report. A module of experiments has EXPERIMENTS, a list of experiment.Experiment.
MODULES = ('feet', 'swing', 'joints', 'hrp2p', 'laws', 'beyond', 'push', 'plans', 'story', 'story_walking')


def load_experiments():
    return [e for module in MODULES for e in importlib.import_module(module).EXPERIMENTS]


def choose(words, experiments):
    groups = {'all': experiments}
    for e in experiments:
        groups.setdefault(e.group, []).append(e)
    known = {e.name: [e] for e in experiments}
    chosen = []
    for word in words:
        if word not in groups and word not in known:
            sys.exit("no experiment '%s'; there are %s" % (word, ', '.join(list(groups) + list(known))))
        chosen += [e for e in groups.get(word, known.get(word)) if e not in chosen]
    return chosen


def do(experiment, options, progress):
    outcome, begin = Outcome(), time.time()
    run = Runner(options.bin, os.path.join(options.out, experiment.name), options.vendors, options.runs,
                 lambda what: progress.tell(experiment, what), options.short)
    try:
        experiment.measure(run, outcome)
    except Skipped as reason:
        outcome.skipped = str(reason)
        outcome.see('NOT RUN: ' + outcome.skipped)
    except Exception as error:  # an experiment that cannot be run is a failed one, and the others go on
        outcome.claim('it can be run: %s: %s' % (type(error).__name__, error), False)
    outcome.seconds = time.time() - begin
    progress.finish(experiment, outcome)
    return outcome


def do_all(chosen, options, save):
    """As many at a time as there are cores, the longest first, so that none is left over at the end. save(results so far)
    after each."""
    progress = Progress(chosen)
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(1, options.jobs)) as pool:
        futures = {e.name: pool.submit(do, e, options, progress) for e in sorted(chosen, key=lambda e: -e.cost)}
        try:
            for _ in concurrent.futures.as_completed(futures.values()):
                save([(e, futures[e.name].result()) for e in chosen if futures[e.name].done()])
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return [(e, futures[e.name].result()) for e in chosen]


def find_commit():
    try:
        words = ['git', '-C', ROOT, 'describe', '--always', '--dirty', '--exclude', '*']
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return 'unknown (no git here)'


def save(results, options, begin):
    took = print_duration(time.time() - begin)
    words = 'Made in %s min on %d cores with %s, from commit %s; scripts/experiments.sh makes it anew.' % (
        took, os.cpu_count(), ' and '.join(VENDORS[v] for v in options.vendors), find_commit())
    for name, text in (('report.html', make_page(results, words)), ('table.md', make_table(results))):
        with open(os.path.join(options.out, name), 'w') as file:
            file.write(text)


def read_options():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', default=['all'])
    parser.add_argument('--bin', default=os.path.join(ROOT, 'build', 'bin'))
    parser.add_argument('--out', default=os.path.join(ROOT, 'logs', 'experiments'))
    parser.add_argument('--dds', default='both', choices=['both'] + list(VENDORS))
    parser.add_argument('--runs', type=int, default=10)
    parser.add_argument('--jobs', type=int, default=os.cpu_count())
    parser.add_argument('--walking', action='store_true')
    parser.add_argument('--short', action='store_true')
    parser.add_argument('--list', action='store_true')
    options = parser.parse_args()
    if options.walking:
        if options.names != ['story']:
            parser.error('--walking belongs to the story: story --walking')
        options.names = ['story_walking']
    options.out = os.path.abspath(options.out)
    os.makedirs(options.out, exist_ok=True)
    options.vendors = list(VENDORS) if options.dds == 'both' else [options.dds]
    return options


def main():
    options, experiments = read_options(), load_experiments()
    if options.list:
        print('\n'.join('%-12s %s' % (e.name, e.title) for e in experiments))
        return 0
    chosen, begin = choose(options.names, experiments), time.time()
    try:
        results = do_all(chosen, options, lambda so_far: save(so_far, options, begin))
    except KeyboardInterrupt:
        sys.exit('stopped; what was done is in ' + os.path.join(options.out, 'report.html'))
    failed = [e.name for e, o in results if o.verdict() == 'FAIL']
    passed = sum(1 for _, o in results if o.verdict() == 'pass')
    print('%d of %d pass%s, %s min' % (passed, len(results), '; not: ' + ', '.join(failed) if failed else '',
                                       print_duration(time.time() - begin)))
    print('report: ' + os.path.join(options.out, 'report.html'))
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
