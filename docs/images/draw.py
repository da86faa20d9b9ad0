#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of the documents that no program writes.

docs/images/draw.py joint_laws           laws of a joint (docs/images/joint_laws.svg)
docs/images/draw.py foot                 a foot with its rubber, frames and sensor (foot.svg)
docs/images/draw.py frames               frames, poses and a contact as the code names them (frames.svg)
docs/images/draw.py signals              what each signal of a standing robot sees (signals.svg)
docs/images/draw.py missing DIR          missing torque of a joint of models/experiments/arm (missing_torque.svg); DIR is the
                                         answer of `scripts/diagnose.sh models/experiments/arm/experiment.yaml --out DIR`
docs/images/draw.py next DIR             predictions along the first proposed motion (next_experiment.svg); DIR is the answer of
                                         `scripts/diagnose.sh models/experiments/lifter/experiment.yaml --out DIR --next --seconds 6`
docs/images/draw.py walk CSV             vertical forces of both feet (walk_forces.svg); CSV is made by
                                         `scripts/simulate.sh --log run.mcap; build/bin/hrp-log csv run.mcap --out CSV`
docs/images/draw.py paper DIR            foot forces of figures 6, 7 and 11 of the 2003 paper (paper_forces.svg). For N = 6, 7, 11:
                                         `scripts/simulate.sh models/scenarios/paper_a/figN.yaml --log figN.mcap`. In DIR then
                                         `build/bin/hrp-log csv figN.mcap --out figN.csv`, and for 11 `hrp-log cat fig11.mcap
                                         contact_forces --json --from 4 --to 10 > fig11.jsonl`
"""
import csv
import json
import pathlib
import re
import sys

import matplotlib
matplotlib.use('svg')
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import FancyArrowPatch, Rectangle  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
BLUE, RED, GREY, GREEN = '#1f5fa8', '#c23b22', '#888888', '#2e7d4f'
plt.rcParams.update({'font.size': 8, 'axes.spines.top': False, 'axes.spines.right': False, 'svg.hashsalt': 'docs',
                     'axes.titlesize': 8.5, 'legend.frameon': False, 'legend.fontsize': 7, 'lines.linewidth': 1.4})


def save(figure, name):
    figure.savefig(HERE / name, metadata={'Date': None}, bbox_inches='tight')
    print(HERE / name)


def name_axes(axes, title, x, y, legend=True):
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.axhline(0, color=GREY, linewidth=0.5)
    axes.axvline(0, color=GREY, linewidth=0.5)
    if legend:
        axes.legend(handlelength=1.2)


def draw_friction(axes):
    v = np.linspace(-1, 1, 1001)
    axes.plot(v, 0.7 * v, color=GREEN, label='viscous_friction')
    axes.plot(v, 0.45 * np.sign(v), color=BLUE, label='coulomb_friction')
    axes.plot(v, np.sign(v) * (0.4 + 0.4 * np.exp(-(v / 0.12) ** 2)) + 0.35 * v, color=RED, label='stribeck_friction')
    name_axes(axes, 'Friction over speed', 'speed', 'friction')


def draw_load(axes):
    load = np.linspace(-1, 1, 401)
    axes.plot(load, 0.5 * np.abs(load), color=BLUE, label='load_dependent_friction')
    axes.plot(load, np.where(load < 0, -0.5 * load, 0), color=RED, linestyle='--', label='backdriving_friction')
    name_axes(axes, 'Friction over load', 'load drives | drive lifts', 'friction')


def draw_effort(axes):
    u = np.linspace(-1, 1, 401)
    axes.plot(u, u, color=GREY, label='nominal')
    axes.plot(u, 0.7 * u, color=BLUE, label='torque_constant_error')
    axes.plot(u, np.clip(u, -0.5, 0.5), color=RED, linestyle='--', label='torque_saturation')
    axes.plot(u, u - np.clip(u, -0.2, 0.2), color=GREEN, linestyle='-.', label='dead_zone')
    name_axes(axes, 'Torque over command', 'commanded effort', 'torque')


def draw_time(axes):
    t = np.linspace(0, 1, 401)
    axes.plot(t, t > 0.1, color=GREY, label='command')
    axes.plot(t, t > 0.3, color=BLUE, label='command_delay')
    axes.plot(t, np.where(t > 0.1, 1 - np.exp(-(t - 0.1) / 0.2), 0), color=RED, linestyle='--', label='actuator_lag')
    name_axes(axes, 'Torque after a step', 'time', 'torque')


def draw_position(axes):
    q = np.linspace(-1, 1, 801)
    axes.plot(q, -0.8 * (q - 0.2), color=BLUE, label='parallel_spring')
    axes.plot(q, 0.25 * np.sin(22 * q), color=RED, label='cogging')
    name_axes(axes, 'Torque over position', 'position', 'torque')


def draw_hysteresis(axes):
    q = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, -1, 600), np.linspace(-1, 1, 600)])
    z, path = 0.0, []
    for step in np.diff(q, prepend=0.0):
        z += step / 0.2 * (1 - abs(z) * (0.5 + 0.5 * np.sign(z * step)))
        path.append(0.6 * z)
    axes.plot(q[300:], path[300:], color=RED, label='hysteresis')
    name_axes(axes, 'A torque that remembers', 'position', 'torque')


def draw_transmission(axes):
    u = np.linspace(-1, 1, 401)
    axes.plot(u, u, color=GREY, label='rigid')
    axes.plot(u, 0.6 * u, color=BLUE, label='joint_elasticity')
    axes.plot(u, np.sign(u) * 0.35 + 0.1 * u, color=RED, linestyle='--', label='backlash')
    name_axes(axes, 'Twist of the gear', 'torque on the gear', 'twist', legend=False)
    axes.lines[0].set_ydata(0 * u)
    axes.legend(handlelength=1.2)


def draw_rotor(axes):
    a = np.linspace(-1, 1, 3)
    axes.plot(a, 0.45 * a, color=GREY, label='links')
    axes.plot(a, 0.9 * a, color=BLUE, label='with rotor_inertia')
    name_axes(axes, 'Torque over acceleration', 'acceleration', 'torque')


def draw_joint_laws():
    figure, grid = plt.subplots(2, 4, figsize=(10.5, 4.6))
    for draw, axes in zip([draw_friction, draw_load, draw_effort, draw_time, draw_position, draw_hysteresis, draw_transmission,
                           draw_rotor], grid.flat):
        draw(axes)
    figure.tight_layout()
    save(figure, 'joint_laws.svg')


def put_arrow(axes, start, end, text, color=RED, where=(4, 4), **style):
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle='-|>', mutation_scale=10, color=color, linewidth=1.4, **style))
    axes.annotate(text, end, xytext=where, textcoords='offset points', color=color)


def draw_foot():
    figure, both = plt.subplots(1, 2, figsize=(9, 3.6))
    for axes, tilt, title in zip(both, (0.0, 0.16), ('unloaded', 'leaning: pitch q of the upper part U over the sole S')):
        turn = matplotlib.transforms.Affine2D().rotate_around(0, 0.25, -tilt) + axes.transData
        axes.plot([-2, 2], [0, 0], color=GREY, linewidth=1)
        axes.add_patch(Rectangle((-1.2, 0), 2.4, 0.12, color='#bbbbbb'))
        axes.text(1.25, 0.03, 'sole S')
        zigzag = np.array([[-0.8, 0.8]])
        for x in zigzag[0]:
            top = 0.38 - tilt * x
            y = np.linspace(0.12, top, 9)
            axes.plot(x + 0.06 * np.array([0, 1, -1, 1, -1, 1, -1, 1, 0]), y, color=BLUE)
        axes.text(-1.95, 0.2, 'rubber:\nK, C, O', color=BLUE)
        axes.add_patch(Rectangle((-1.1, 0.38), 2.2, 0.14, color='#dddddd', transform=turn))
        axes.add_patch(Rectangle((-0.25, 0.52), 0.5, 0.16, color='#e8c46a', transform=turn))
        axes.add_patch(Rectangle((-0.14, 0.68), 0.28, 0.75, color='#dddddd', transform=turn))
        axes.plot([0], [0.25], 'o', color='black', markersize=4)
        axes.annotate('bush centre', (0, 0.25), xytext=(8, -3), textcoords='offset points')
        place = turn.transform([(0.3, 0.6), (0.2, 1.2), (0.8, 0.62)])
        place = axes.transData.inverted().transform(place)
        axes.text(*place[0], 'force sensor', color='#8a6d1f')
        axes.text(*place[1], 'ankle')
        if tilt:
            put_arrow(axes, (0, 0.25), (0, 1.65), 'gravity\'s\nvertical', GREY, (-42, -12), linestyle='--')
            end = axes.transData.inverted().transform(turn.transform((0, 1.75)))
            put_arrow(axes, (0, 0.25), tuple(end), 'z of U', RED, (4, -4))
            axes.text(0.03, 1.05, 'q', color=RED)
        axes.set_title(title)
        axes.set_xlim(-2, 2)
        axes.set_ylim(-0.1, 1.95)
        axes.axis('off')
    figure.tight_layout()
    save(figure, 'foot.svg')


def put_frame(axes, origin, angle, name, length=0.55):
    for turn, label in ((angle, 'x'), (angle + np.pi / 2, 'z')):
        end = origin + length * np.array([np.cos(turn), np.sin(turn)])
        put_arrow(axes, tuple(origin), tuple(end), label, 'black', (2, 2))
    axes.plot(*origin, 'o', color='black', markersize=3)
    axes.text(origin[0] - 0.14, origin[1] - 0.2, name, fontsize=11, fontweight='bold')


def draw_frames():
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.3), width_ratios=[1.3, 1])
    W, A, B, Q = np.array([0.0, 0.0]), np.array([2.2, 0.35]), np.array([4.2, 1.1]), np.array([4.9, 2.1])
    for origin, angle, name in ((W, 0, 'W'), (A, 0.25, 'A'), (B, 0.6, 'B')):
        put_frame(left, origin, angle, name)
    left.plot(*Q, 'o', color=RED, markersize=5)
    left.text(Q[0] + 0.08, Q[1] + 0.05, 'Q', color=RED, fontsize=11, fontweight='bold')
    for start, end, text, color, where in ((A, B, 'X_AB', BLUE, (-62, -26)), (B, Q, 'p_BQ', RED, (-20, -34)), (A, Q, 'p_AQ', RED, (-96, -34))):
        put_arrow(left, tuple(start), tuple(end), '', color, connectionstyle='arc3,rad=0.08', linestyle='--')
        left.annotate(text, tuple(end), xytext=where, textcoords='offset points', color=color)
    left.set(title='p_AQ = X_AB * p_BQ', xlim=(-0.4, 5.6), ylim=(-0.35, 2.6), aspect='equal')
    right.fill_between([-0.2, 3.2], 0, -0.5, color='#dddddd')
    right.text(2.6, -0.35, 'body B')
    right.add_patch(Rectangle((0.6, -0.12), 1.8, 0.7, facecolor='#b8d0ea', alpha=0.7))
    right.text(0.7, 0.38, 'body A')
    right.plot(0.6, -0.12, 'o', color=RED)
    right.text(0.42, -0.34, 'C', color=RED, fontsize=11, fontweight='bold')
    put_arrow(right, (0.6, -0.12), (0.6, 0.85), 'n_BA', RED, (4, -4))
    put_arrow(right, (1.5, 0.0), (1.5, 1.25), 'force of the pair: on A', BLUE, (4, -4))
    right.annotate('', (2.55, 0), xytext=(2.55, -0.12), arrowprops={'arrowstyle': '<->', 'shrinkA': 0, 'shrinkB': 0, 'mutation_scale': 6})
    right.text(2.62, 0.06, 'depth > 0')
    right.set(title='contact', xlim=(-0.2, 3.2), ylim=(-0.5, 1.5), aspect='equal')
    for axes in (left, right):
        axes.axis('off')
    figure.tight_layout()
    save(figure, 'frames.svg')


def draw_signals():
    figure, axes = plt.subplots(figsize=(7.5, 4.4))
    joints = {'ankle': (0.0, 0.3), 'knee': (0.35, 1.1), 'hip': (0.0, 1.9), 'trunk': (0.05, 2.9)}
    x, y = zip(*joints.values())
    axes.plot(x, y, color='#555555', linewidth=9, solid_capstyle='round', alpha=0.35)
    axes.plot([-0.35, 0.5], [0.1, 0.1], color='#555555', linewidth=7, solid_capstyle='round', alpha=0.35)
    axes.plot([-1.3, 1.6], [0, 0], color=GREY, linewidth=1)
    axes.plot(x[:3], y[:3], 'o', color='white', markeredgecolor='black', markersize=8)
    axes.add_patch(Rectangle((-0.12, 2.5), 0.3, 0.16, color=GREEN))
    axes.add_patch(Rectangle((-0.14, 0.17), 0.28, 0.08, color='#e8c46a'))
    notes = [((0.2, 2.58), 'IMU: attitude, rates, specific force', 'balance, tilt, gyroscope', GREEN),
             ((0.1, 1.9), 'encoder and effort (or command and gains)', 'joint: friction, rotor, gain, lag', BLUE),
             ((0.42, 1.1), 'all encoders', 'where each link is; servo: delay, scale of the effort', BLUE),
             ((0.16, 0.21), 'six-axis force sensor', 'balance of the whole body: masses, loads, pushes', '#8a6d1f'),
             ((0.4, 0.06), 'the sole lies flat on the ground', 'tilt: soft sole, slope. height: how far a sole sinks', RED)]
    for (place, what, shows, color), row in zip(notes, (2.75, 2.1, 1.45, 0.8, 0.15)):
        axes.annotate('%s\n' % what, place, xytext=(1.7, row), color=color, va='center',
                      arrowprops={'arrowstyle': '-', 'color': color, 'linewidth': 0.7})
        axes.text(1.7, row - 0.13, shows, color='#444444', va='center', fontsize=7)
    axes.set_xlim(-1.3, 5.2)
    axes.set_ylim(-0.15, 3.15)
    axes.axis('off')
    figure.tight_layout()
    save(figure, 'signals.svg')


def read_columns(path, names):
    with open(path, encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    return [np.array([float(row[name] or 'nan') for row in rows]) for name in names]


def draw_missing(folder):
    torque = json.loads((pathlib.Path(folder) / 'series.json').read_text())['torque_traces']
    trace = torque['traces'][0]
    name = torque['signals'][trace['signal']]['name'].split('/')[2]
    t, recorded, before = (np.array(trace[key]) for key in ('time', 'recorded', 'before'))
    recording = HERE.parent.parent / 'models/experiments/arm' / torque['recording']
    times, speeds = read_columns(recording, ['time', '/joint_states/%s/velocity' % name])
    v = np.interp(t, times - times[0], speeds)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3), width_ratios=[1.6, 1])
    left.plot(t, recorded, color='black', label='recorded effort')
    left.plot(t, before, color=RED, linestyle='--', label='nominal model')
    left.fill_between(t, recorded, before, color=RED, alpha=0.15, label='missing torque')
    left.set(title='%s of %s, held out' % (name, torque['recording']), xlabel='time [s]', ylabel='effort [N m]')
    left.legend(ncol=3, loc='upper left')
    left.set_ylim(-1.2, 3.0)
    right.plot(v, recorded - before, 'o', color=RED, markersize=3)
    right.axhline(0, color=GREY, linewidth=0.5)
    right.axvline(0, color=GREY, linewidth=0.5)
    right.set(title='a step at each reversal: dry friction', xlabel='speed of %s [rad/s]' % name, ylabel='missing torque [N m]')
    figure.tight_layout()
    save(figure, 'missing_torque.svg')


def draw_next(folder):
    page = (pathlib.Path(folder) / 'next/next.html').read_text()
    plots = re.findall(r"<svg viewBox='0 0 640 220'.*?>(.*?)</svg>", page, re.DOTALL)[:2]
    names = re.findall(r"<span style='color:(#\w+)'>&#9632;</span> (\S+) &nbsp;", page.split('</svg>')[2])
    parts = ["<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 660 490' font-family='sans-serif' font-size='11' role='img' "
             "aria-label='predictions along the first motion'><rect width='100%' height='100%' fill='white'/>"]
    parts += ["<g transform='translate(0 %d)'>%s</g>" % (215 * i, plot) for i, plot in enumerate(plots)]
    parts += ["<text x='%d' y='%d' fill='%s'>&#9632; %s</text>" % (60 + 195 * (i % 3), 450 + 16 * (i // 3), color, name)
              for i, (color, name) in enumerate(names)]
    (HERE / 'next_experiment.svg').write_text(''.join(parts) + '</svg>\n')


def draw_walk(path, begin=4.0, end=8.6):
    columns = ['time'] + ['/wrench/%s_foot/force/z' % side for side in ('left', 'right')]
    t, left, right = read_columns(path, columns)
    kept = (t >= begin) & (t <= end)
    t, left, right = t[kept], left[kept], right[kept]
    weight = np.median((left + right)[(left > 0) & (right > 0)])
    figure, axes = plt.subplots(figsize=(9.5, 2.9))
    axes.plot(t, left, color=BLUE, label='left foot')
    axes.plot(t, right, color=RED, label='right foot')
    axes.axhline(weight, color=GREY, linewidth=0.7, linestyle='--')
    axes.text(begin, weight * 1.06, 'weight', color=GREY)
    both = (left > 0.2 * weight) & (right > 0.2 * weight)
    axes.fill_between(t, 0, 1, where=both, transform=axes.get_xaxis_transform(), color=GREY, alpha=0.2, linewidth=0,
                      label='double support')
    axes.set(xlabel='time [s]', ylabel='vertical force [N]')
    axes.legend(ncol=3, loc='lower left', bbox_to_anchor=(0, 1))
    figure.tight_layout()
    save(figure, 'walk_forces.svg')


def read_forces(path):
    """Time, vertical force of the left and of the right sole."""
    rows = []
    for line in open(path, encoding='utf-8'):
        sample = json.loads(line)
        forces = {'L': 0.0, 'R': 0.0}
        for pair in sample['message']['pairs']:
            forces[pair['name_a'][0]] += pair['total']['force']['z']
        rows.append((sample['time'], forces['L'], forces['R']))
    return np.array(rows).T


def draw_paper(folder):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3), width_ratios=[1.5, 1])
    for number, color, width, text in ((6, RED, 0.6, 'figure 6: joints that follow perfectly'), (7, BLUE, 1.4, 'figure 7: joint servos')):
        t, force = read_columns('%s/fig%d.csv' % (folder, number), ['time', '/wrench/left_foot/force/z'])
        left.plot(t, force, color=color, linewidth=width, label=text)
    left.set(xlim=(5.5, 8.5), xlabel='time [s]', ylabel='left force sensor [N]', title='HRP-1S walks')
    left.set_ylim(-1500, 4000)
    left.legend(loc='upper right', ncol=2)
    t, *feet = read_forces('%s/fig11.jsonl' % folder)
    for force in feet:
        air = 0
        for i in range(len(t) - 250):
            if force[i] > 5.0 and air > 150:
                right.plot(1e3 * (t[i:i + 250] - t[i]), force[i:i + 250], color=BLUE, linewidth=0.7)
            air = air + 1 if force[i] <= 5.0 else 0
    for level, text in ((500, 'first peak'), (100, 'dip'), (550, 'load')):
        right.axhline(level, color=GREY, linewidth=0.7, linestyle='--')
        right.text(252, level, text, color=GREY, va='bottom' if level == 550 else 'top' if level == 500 else 'center')
    right.set(xlim=(0, 250), ylim=(-20, 900), xlabel='time since the first touch [ms]', ylabel='force of the ground [N]', title='HRP-2P lands (figure 11)')
    figure.tight_layout()
    save(figure, 'paper_forces.svg')


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ('-h', '--help'):
        print(__doc__.strip())
        return
    {'joint_laws': draw_joint_laws, 'foot': draw_foot, 'frames': draw_frames, 'signals': draw_signals, 'missing': draw_missing,
     'next': draw_next, 'walk': draw_walk, 'paper': draw_paper}[sys.argv[1]](*sys.argv[2:])


if __name__ == '__main__':
    main()
