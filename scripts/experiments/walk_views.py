# SPDX-License-Identifier: BSD-3-Clause
"""What a walk looks like: the vertical foot force, as the paper plots it, and pictures of the robot, as the paper shows."""
import re

LEFT, RIGHT = 'L_ANKLE_R_LINK/force_z', 'R_ANKLE_R_LINK/force_z'
RATE = 1000.0  # [Hz] of the tables, the physics step


def find_feet(text):
    """Columns of the left and the right foot of a scenario; it names the left one first."""
    return tuple(name.strip() + '/force_z' for name in re.search(r'(?m)^feet: \[(.*)\]', text)[1].split(','))


def cut(columns, begin, end):
    """Columns between two times [s]."""
    chosen = [i for i, t in enumerate(columns['time']) if begin <= t <= end]
    return {key: [values[i] for i in chosen] for key, values in columns.items()}


def find_end(summary, columns):
    return summary['fall_time'] if summary['fallen'] else columns['time'][-1]


def add_foot_force(run, out, name, summary, columns, feet=(LEFT, RIGHT)):
    c = cut(columns, 0.0, find_end(summary, columns))
    out.figure('Vertical force on each foot%s.' % (', until the fall' if summary['fallen'] else ''),
               run.plot(name + '_force', 'Vertical force on each foot', 'time [s]', 'force [N]', c['time'],
                        {'left foot': c[feet[0]], 'right foot': c[feet[1]]}))


def find_walk(columns, feet=(LEFT, RIGHT)):
    """From before the first foot leaves the ground until after the last one has come down [s]."""
    air = [t for t, a, b in zip(columns['time'], columns[feet[0]], columns[feet[1]]) if (a == 0.0 or b == 0.0) and t > 1.0]
    return (max(0.0, air[0] - 0.1), min(columns['time'][-1], air[-1] + 0.3)) if air else (0.0, columns['time'][-1])


def add_pictures(run, out, name, summary, columns, span=None, options=(), words='', feet=(LEFT, RIGHT)):
    """Of the whole walk, of a span of time, or of a fall, from two seconds before it."""
    begin, end = span or find_walk(columns, feet)
    if summary['fallen']:
        begin, end = max(0.0, summary['fall_time'] - 1.8), summary['fall_time'] + 1.0  # the log goes on after the fall
        words = 'the fall, until the robot lies on the floor'
    caption = 'From the log of the server set: %s. Left limbs blue, right ones orange; thin lines every 0.2 m, heavy ones every ' \
              'metre; the camera goes along.' % (words or 'the walk')
    out.figure(caption, run.pictures(name, summary['log'], begin, end, options))
