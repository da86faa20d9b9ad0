# SPDX-License-Identifier: BSD-3-Clause
"""What a walk looks like: the vertical foot force, as the paper plots it, and pictures of the robot, as the paper shows."""
LEFT, RIGHT = 'L_ANKLE_R_LINK/force_z', 'R_ANKLE_R_LINK/force_z'
RATE = 1000.0  # [Hz] of the tables, the physics step


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


def add_pictures(run, out, name, summary, columns, begin=2.0, end=None, options=(), words=''):
    """Of the whole walk, or of the last two seconds before a fall."""
    last = columns['time'][-1]
    if summary['fallen']:
        begin, end = max(0.0, summary['fall_time'] - 1.8), min(last, summary['fall_time'] + 0.5)
    end = last if end is None else min(end, last)
    caption = 'From the log of the server set: %s. Left limbs blue, right ones orange; thin lines every 0.2 m, heavy ones every ' \
              'metre; the camera goes along.' % ('the fall, until the body reaches the floor' if summary['fallen'] else words or 'the walk')
    out.figure(caption, run.pictures(name, summary['log'], begin, end, options))
