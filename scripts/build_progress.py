#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads what ninja prints with NINJA_STATUS="[%f/%t %e] " and says how far the build is and how long it will take.

On a terminal one line is redrawn. Elsewhere a line is printed for each tenth of the way. Everything else that ninja or a
compiler says is passed on. The estimate assumes that the steps to come take as long as those so far.
"""
import re
import sys

STATUS = re.compile(r"\[(\d+)/(\d+) ([0-9.]+)\] ")
QUIET = re.compile(r"ninja: (Entering directory|no work to do)")
FEW = 8  # steps that tell nothing about the others: generators and precompiled headers come first


def clock(seconds):
    seconds = int(round(seconds))
    return f"{seconds // 60}:{seconds % 60:02d}"


def describe(done, total, elapsed):
    """One line: steps, time so far, time left once there is something to judge it by."""
    line = f"build {done}/{total}, {clock(elapsed)} min"
    if done == total:
        return line
    if done < FEW:
        return line
    return f"{line}, about {clock(elapsed / done * (total - done))} min left"


class Progress:
    def __init__(self, out, terminal):
        self.out, self.terminal = out, terminal
        self.tenth = 0
        self.drawn = False  # a line without its end stands on the terminal

    def step(self, done, total, elapsed):
        line = describe(done, total, elapsed)
        if self.terminal:
            self.out.write("\r\033[K" + line)
            self.drawn = True
        elif 10 * done // total > self.tenth or done == total:
            self.tenth = 10 * done // total
            self.out.write(line + "\n")
        self.out.flush()

    def end_line(self):
        if self.drawn:
            self.out.write("\n")
        self.drawn = False

    def read(self, line):
        status = STATUS.match(line)
        if status:
            self.step(int(status[1]), int(status[2]), float(status[3]))
        elif not QUIET.match(line):
            self.end_line()
            self.out.write(line)
            self.out.flush()


def main():
    progress = Progress(sys.stdout, sys.stdout.isatty())
    for line in iter(sys.stdin.readline, ""):
        progress.read(line)
    progress.end_line()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:  # ninja says what was interrupted
        sys.exit(130)
