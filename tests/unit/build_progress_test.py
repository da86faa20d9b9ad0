#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""build_progress_test.py: a build says how far it is and how long it will take, and passes on what compilers say."""
import io
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / 'scripts'))
import build_progress  # noqa: E402


def show(lines, terminal=False):
    out = io.StringIO()
    progress = build_progress.Progress(out, terminal)
    for line in lines:
        progress.read(line)
    progress.end_line()
    return out.getvalue()


class Progress(unittest.TestCase):
    def test_the_time_left_is_that_of_the_steps_so_far(self):
        self.assertEqual(build_progress.describe(50, 200, 60.0), 'build 50/200, 1:00 min, about 3:00 min left')

    def test_a_few_steps_tell_nothing(self):
        self.assertEqual(build_progress.describe(3, 200, 9.0), 'build 3/200, 0:09 min')

    def test_a_log_gets_a_line_for_each_tenth(self):
        shown = show('[%d/100 %d.0] Building CXX object a.o\n' % (i, i) for i in range(1, 101))
        self.assertEqual(len(shown.splitlines()), 10)
        self.assertTrue(shown.endswith('build 100/100, 1:40 min\n'))

    def test_what_a_compiler_says_is_passed_on(self):
        for terminal in (False, True):
            shown = show(['[1/9 1.0] Building CXX object a.o\n', 'a.cpp:7: error: expected ;\n'], terminal)
            self.assertIn('\na.cpp:7: error: expected ;\n' if terminal else 'a.cpp:7: error: expected ;\n', shown)

    def test_ninja_itself_is_not_repeated(self):
        self.assertEqual(show(["ninja: Entering directory `build'\n", 'ninja: no work to do.\n']), '')


if __name__ == '__main__':
    unittest.main()
