# SPDX-License-Identifier: BSD-3-Clause
"""One line on the terminal: what is done, what goes on, how long it will take. In a log file: a line an experiment."""
import shutil
import sys
import threading
import time


def print_duration(seconds):
    return '%d:%02d' % divmod(round(seconds), 60)


class Progress:
    def __init__(self, experiments):
        self.total, self.cost = len(experiments), sum(e.cost for e in experiments)
        self.done, self.cost_done, self.begin = 0, 0.0, time.time()
        self.now, self.lock, self.live = {}, threading.Lock(), sys.stdout.isatty()

    def tell(self, experiment, what):
        with self.lock:
            self.now[experiment.name] = what
            self.draw()

    def finish(self, experiment, outcome):
        with self.lock:
            self.now.pop(experiment.name, None)
            self.done, self.cost_done = self.done + 1, self.cost_done + experiment.cost
            self.erase()
            left = '' if self.done == self.total else ', about %s left' % print_duration(self.calc_left())
            print('[%d/%d] %-12s %s (%.0f s%s)' % (self.done, self.total, experiment.name, outcome.verdict(),
                                                   outcome.seconds, left))
            if outcome.skipped:
                print('        ' + outcome.skipped)
            for text, holds in outcome.claims:
                if not holds:
                    print('        does not hold: ' + text)
            sys.stdout.flush()
            self.draw()

    def calc_left(self):
        """[s] from the shares of time that experiments take on an idle machine and the time taken so far."""
        share = self.cost_done / self.cost
        return (time.time() - self.begin) * (1.0 - share) / share if share > 0.0 else self.cost

    def erase(self):
        if self.live:
            sys.stdout.write('\r\033[K')

    def draw(self):
        if not self.live or self.done == self.total:
            return
        line = '[%d/%d, %s] %s' % (self.done, self.total, print_duration(time.time() - self.begin),
                                   ' | '.join(self.now.values()))
        self.erase()
        sys.stdout.write(line[:shutil.get_terminal_size().columns - 1])
        sys.stdout.flush()
