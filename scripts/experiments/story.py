# SPDX-License-Identifier: BSD-3-Clause
"""The path of [H03] once more, walked by the diagnosis tool: a robot with soft feet, servos and rotor inertia sways
through the server set; the tool starts from rigid feet and massless rotors and says, one after the other, what is missing."""
import html
import json
import math
import os
import random
import re
import subprocess
import sys

from experiment import Experiment
from measure import median
from runs import ROOT

MODEL = os.path.join(ROOT, 'models', 'hrp2p_like', 'hrp2p_like.urdf')
STAND = os.path.join(ROOT, 'models', 'scenarios', 'hrp2p_stand.yaml')
# Twice the stiffness that [M14] found in HRP-2's feet: soft enough to be seen, stiff enough to sway on without a stabilizer.
BUSH = {'kz': 3.0e5, 'cz': 1000.0, 'k_roll': 700.0, 'k_pitch': 950.0, 'c_roll': 10.0, 'c_pitch': 12.0}
CENTRE = [0, 0, -0.105]  # [m] underside of the sole
# The joints whose rotors the story leaves out, with the inertia that the model gives them: those that carry a swaying body.
ROTORS = ('R_KNEE', 'L_KNEE', 'R_ANKLE_P', 'L_ANKLE_P')
BEGIN = 1.0  # [s] set on its soles, the robot first sinks into them, faster than the tool's windows resolve
# Seeds of motions that keep the centres of pressure off the soles' edges: beyond them a foot rolls, and its tilt says nothing.
RECORDINGS = (('train_1', 'sway', 10), ('train_2', 'squat', 12), ('validate_1', 'squat', 11))
DURATION, SHORT = 7.0, 5.0  # [s] of a recording; of the two squats that are enough for the claims
# Noise of sensors that a humanoid carries, as in models/scenarios/paper_b/foot.yaml.
SENSORS = """sensors:
  imu:
    chest: {link: CHEST_IMU, gyro: {noise: 6.0e-4}, accelerometer: {noise: 0.014}}
  wrench:
    left_foot: {link: L_ANKLE_R_LINK, force: {noise: 0.3}, torque: {noise: 0.02}}
    right_foot: {link: R_ANKLE_R_LINK, force: {noise: 0.3}, torque: {noise: 0.02}}
  encoders: {position_noise: 5.0e-6, velocity_noise: 1.0e-3, effort_noise: 0.05}
"""
PERFECT_SENSORS = """sensors:
  imu: {chest: {link: CHEST_IMU}}
  wrench: {left_foot: {link: L_ANKLE_R_LINK}, right_foot: {link: R_ANKLE_R_LINK}}
"""


def make_curve(draw, amplitude, low, high):
    """Three sines of random frequency [Hz], faded in within the second after BEGIN."""
    terms = [(draw.uniform(0.4, 1.0), math.exp(draw.uniform(math.log(low), math.log(high))), draw.uniform(0.0, 6.28)) for _ in range(3)]
    total = sum(term[0] for term in terms)

    def curve(t):
        s = min(1.0, max(0.0, t - BEGIN))
        fade = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        return fade * amplitude / total * sum(a * math.sin(2.0 * math.pi * f * t + p) for a, f, p in terms)
    return curve


def make_motion(seed, kind, start, duration, rate=100):
    """CSV of joint angles: both legs sway sideways and lean slowly, which tilts the soles, and bend the knees quickly: an
    inertia shows in accelerations only, and those of a rotor of 0.16 kg m^2 at 2 Hz and 0.06 rad ask for 1.5 N m, thirty
    times the noise of an effort; at 0.7 Hz they would ask for 0.2 N m."""
    draw = random.Random(seed)
    roll, lean = make_curve(draw, 0.035, 0.2, 0.7), make_curve(draw, 0.008, 0.2, 0.6)
    knee = make_curve(draw, 0.06 if kind == 'squat' else 0.04, 0.8, 2.0)
    free = {j: make_curve(draw, 0.3, 0.3, 1.0) for j in ('R_SHOULDER_P', 'L_SHOULDER_P', 'R_ELBOW', 'L_ELBOW')}
    free.update({'WAIST_P': make_curve(draw, 0.02, 0.2, 0.7), 'WAIST_Y': make_curve(draw, 0.1, 0.3, 1.5)})
    names = sorted(set(start) | set(free) | {s + j for s in 'RL' for j in ('_HIP_R', '_ANKLE_R')})
    lines = ['time,' + ','.join(names)]
    for k in range(int(duration * rate) + 1):
        t = k / rate
        q = {n: start.get(n, 0.0) + (free[n](t) if n in free else 0.0) for n in names}
        for s in 'RL':
            bend = knee(t)
            q[s + '_HIP_R'] += roll(t)
            q[s + '_ANKLE_R'] -= roll(t)
            q[s + '_KNEE'] += bend
            q[s + '_HIP_P'] -= bend / 2.0
            q[s + '_ANKLE_P'] += lean(t) - bend / 2.0
        lines.append('%.3f,' % t + ','.join('%.8f' % q[n] for n in names))
    return '\n'.join(lines) + '\n'


def read_stand():
    """The standing scenario without sensors and controller, and its pose."""
    with open(STAND) as file:
        text = re.sub(r'(?m)^#.*\n', '', file.read())
    text = re.sub(r'(?s)sensors:.*', '', text)
    pose = {m[1]: float(m[2]) for m in re.finditer(r'(?m)^    (\w+): (-?[\d.]+)$', text[text.index('initial:'):])}
    return text, pose


def read_rotors():
    """{joint: [kg m^2]} of ROTORS, from the model."""
    with open(MODEL) as file:
        text = file.read()
    return {j: float(re.search(r'<rotor inertia="([\d.]+)"', text[text.index('<joint name="%s"' % j):])[1]) for j in ROTORS}


def write_robot(run):
    """The model without rotors: all that the experiment knows of the robot."""
    path = os.path.join(run.out, 'robot.urdf')
    with open(MODEL) as file, open(path, 'w') as out:
        out.write(re.sub(r'(?m)^\s*<rotor [^>]*/>\s*\n', '', file.read()))
    return path


def cut(run, name):
    """Table of a log from BEGIN on."""
    path = os.path.join(run.out, name + '.csv')
    run.call(name, ['hrp-log', 'csv', os.path.join(run.out, name + '.mcap'), '--out', path])
    with open(path) as file:
        lines = file.readlines()
    with open(path, 'w') as file:
        file.writelines(lines[:1] + [line for line in lines[1:] if float(line.split(',', 1)[0]) >= BEGIN])


def record(run):
    """Makes the recordings through the server set and the experiment that knows nothing of feet and rotors."""
    recordings, duration = (RECORDINGS[1:], SHORT) if run.short else (RECORDINGS, DURATION)
    text, pose = read_stand()
    text = text.replace('../hrp2p_like/hrp2p_like.urdf', write_robot(run))
    reality = text + SENSORS + 'rotor_inertia: {%s}\n' % ', '.join('%s: %g' % item for item in read_rotors().items()) + (
        'foot_bush: {default: {%s, center: %s}}\n' % (', '.join('%s: %g' % item for item in BUSH.items()), CENTRE) +
        # As good as rigid: 1e8 N/m under a sole 0.136 m wide is a thousand times the bush.
        'contact: {stiffness: 1.0e+8, tangential_stiffness: 1.0e+7, margin: 0.001}\n'
        # At 1 ms the step of first order itself looks like a velocity sensor that is half a millisecond late.
        'steps: {time_step: 0.00025, control_period: 0.005, duration: %g}\ninterpolation: hermite\n' % duration)
    entries = ''
    for name, kind, seed in recordings:
        motion = os.path.join(run.out, name + '_motion.csv')
        with open(motion, 'w') as file:
            file.write(make_motion(seed, kind, pose, duration))
        run.serve(name, reality + 'controller: {motion: %s}\n' % motion, run.vendors[0], os.path.join(run.out, name + '.mcap'))
        cut(run, name)
        entries += '  - {file: %s.csv, role: %s}\n' % (name, name.split('_')[0])
    return run.write('experiment', text + PERFECT_SENSORS + 'recordings:\n' + entries)


def list_steps(series):
    """[(what was added, held-out error in noise units)], the nominal model first."""
    steps = [(s['effect'] + ''.join(' ' + place for place in s['where'].values()), s['held_out']) for s in series['steps'][1:]]
    return [('rigid feet, rotors without inertia', series['steps'][0]['held_out'])] + steps


def draw_steps(steps):
    """A bar a step, on a logarithmic scale from the noise floor on."""
    top = math.log10(max(2.0, max(v for _, v in steps)))
    parts = []
    for i, (name, value) in enumerate(steps):
        width, y = 400.0 * max(0.004, math.log10(max(1.0, value)) / top), 10 + 34 * i
        label = ('+ ' if i else '') + name.replace('_', ' ')
        parts.append('<text x="250" y="%d" text-anchor="end">%s</text><rect x="260" y="%d" width="%.1f" height="22" fill="%s"/>'
                     '<text x="%.1f" y="%d">%.3g</text>' % (y + 16, html.escape(label), y, width, '#b4500a' if i == 0 else '#0b5fa8',
                                                           268 + width, y + 16, value))
    return ('<svg viewBox="0 0 760 %d" style="font:14px system-ui;fill:currentColor">%s</svg>' % (20 + 34 * len(steps), ''.join(parts)))


def check_feet(report, out):
    """Both soles, with the stiffness that they were given."""
    feet = [f for f in report['findings'] if f['effect'] == 'foot_compliance']
    out.claim('both feet are named', {f['where'].get('foot') for f in feet} == {'L_ANKLE_R_LINK', 'R_ANKLE_R_LINK'})
    for f in feet:
        for key in ('k_roll', 'k_pitch', 'c_roll', 'c_pitch'):
            p = f['parameters'][key]
            out.number('%s %s' % (f['where']['foot'], key),
                       '%.4g +- %.2g %s (given: %g)' % (p['value'], 1.96 * p['std'], p['unit'], BUSH[key]))
    errors = [abs(f['parameters'][k]['value'] / BUSH[k] - 1.0) for f in feet for k in ('k_roll', 'k_pitch')]
    out.claim('stiffness of both soles within 5 %% (largest error %.2g %%)' % (100.0 * max(errors, default=1.0)),
              errors and max(errors) < 0.05)


def tell(run, out, folder):
    with open(os.path.join(folder, 'report.json')) as file:
        report = json.load(file)
    with open(os.path.join(folder, 'series.json')) as file:
        series = json.load(file)
    steps = list_steps(series)
    named = [name for name, _ in steps[1:]]
    out.see('named in this order: %s' % (', '.join(n.replace('_', ' ') for n in named) or 'nothing'))
    out.claim('the first thing named is that the soles give', bool(named) and named[0].startswith('foot_compliance'))
    check_feet(report, out)
    rotors = [f for f in report['findings'] if f['effect'] == 'rotor_inertia']
    out.claim('then the inertia of the rotors behind the joint servos (%d of %d joints)' % (len(rotors), len(ROTORS)),
              rotors and {f['where']['joint'] for f in rotors} == set(ROTORS))
    for f in rotors:
        p = f['parameters']['inertia']
        given = read_rotors().get(f['where']['joint'], 0.0)
        out.number('%s rotor inertia' % f['where']['joint'], '%.3g +- %.2g kg m^2 (given: %g)' % (p['value'], 1.96 * p['std'], given))
    values = [v for _, v in steps]
    out.claim('the held-out error falls at every step (%s times the noise)' % ', '.join('%.3g' % v for v in values),
              len(values) > 1 and all(b < a for a, b in zip(values, values[1:])))
    out.figure('Held-out error of the prediction, in units of the noise, as the tool adds what is missing', draw_steps(steps))
    for u in report['unexplained']:
        out.see(u['statement'])
    out.number('verdict', report['verdict'].replace('_', ' '))
    out.number('the tool\'s own page', os.path.join(os.path.basename(run.out), 'diagnosis', 'report.html'))


def tell_again(run, out, folder):
    """The held-out recording simulated once more, with rigid feet and with what was found."""
    subprocess.run([sys.executable, os.path.join(ROOT, 'scripts', 'diagnosis', 'resimulate.py'), run.bin, folder, 'process'],
                   check=True, capture_output=True)
    with open(os.path.join(folder, 'resimulated.json')) as file:
        signals = json.load(file)['per_signal']
    loads = {n: e for n, e in signals.items() if n.startswith('/wrench/') or n.endswith('/effort')}
    moved = sorted(loads.items(), key=lambda item: -item[1]['before'])[:12]
    for name, e in moved:
        out.number('simulated again: ' + name, '%.3g of its spread before, %.3g after' % (e['before'], e['after']))
    before, after = (median([e[k] for _, e in moved]) for k in ('before', 'after'))
    out.claim('simulated again with what was found, the twelve forces and efforts that were furthest off come nearer '
              '(median error %.3g of their spread, %.3g after)' % (before, after), after < before)


def story(run, out):
    experiment = record(run)
    begin, end = 1.0, SHORT - 1.0 if run.short else DURATION - 1.0
    out.figure('What the robot does: swaying and squatting on soft feet',
               run.pictures('train_2', os.path.join(run.out, 'train_2.mcap'), begin, end))
    run.tell('the tool looks for what is missing')
    folder = os.path.join(run.out, 'diagnosis')
    run.call('diagnosis', ['hrp-diagnose', experiment, '--out', folder, '--quiet'])
    tell(run, out, folder)
    tell_again(run, out, folder)


EXPERIMENTS = [
    Experiment('story', 'The tool finds what took five years',
               'Feet that give were the first reason why simulation and experiment differed, joints that do not follow their '
               'references perfectly (servo and rotor inertia) the second; each was found by hand and the simulation came closer '
               'with each.', story, group='story', cost=240.0)]
