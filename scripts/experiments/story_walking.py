# SPDX-License-Identifier: BSD-3-Clause
"""The path of [H03] from walks alone: a robot with soft soles, joint servos and rotors walks with the paper's controller in
closed loop. The tool starts from rigid feet and joints that follow perfectly, and finds the soles, then servos and rotors.
Each model then walks again with the same controller, beside the recording."""
import argparse
import html
import json
import os
import pathlib
import re
import sys

from experiment import Experiment
from runs import ROOT

sys.path.insert(0, os.path.join(ROOT, 'scripts', 'diagnosis'))
import closed_loop  # noqa: E402
import resimulate  # noqa: E402
import walk_figures  # noqa: E402
import walk_report  # noqa: E402

MODEL = os.path.join(ROOT, 'models', 'hrp1s_like', 'hrp1s_like.urdf')
# Beside walking ahead, a walk aside and one backwards: a hip's roll and a sole's roll hardly show in a straight walk.
WALKS = (('train_1', 'length: 0.2'), ('train_2', 'length: 0.05, side: 0.05'), ('train_3', 'length: -0.1, turn: -0.1'),
         ('validate_1', 'length: 0.15, turn: 0.1'))
SHORT_WALKS = (('train_1', 'length: 0.1, side: 0.05'), ('validate_1', 'length: 0.15, turn: 0.1'))
# Noise of sensors that a humanoid carries, as in models/scenarios/paper_b/foot.yaml.
NOISE = """sensors:
  imu:
    trunk: {link: TRUNK_IMU, gyro: {noise: 6.0e-4}, accelerometer: {noise: 0.014}}
  wrench:
    left_foot: {link: L_ANKLE_R_LINK, force: {noise: 0.3}, torque: {noise: 0.02}}
    right_foot: {link: R_ANKLE_R_LINK, force: {noise: 0.3}, torque: {noise: 0.02}}
  encoders: {position_noise: 5.0e-6, velocity_noise: 1.0e-3, effort_noise: 0.05}
"""
# As good as rigid beside the rubber. One physics step a control period: at the paper's 5 ms the commands' ripple in the
# efforts, sampled at that same period, looks like a rotor that is smaller by kd times half a period.
FLOOR = 'contact: {stiffness: 2.0e+7, tangential_stiffness: 2.0e+7, margin: 0.001}\n'
STEPS = 'steps: {time_step: 0.001, control_period: 0.001, duration: %g}\n'


def drop(text, *keys):
    for key in keys:
        text = resimulate.drop_section(text, key)
    return text


def write_robots(run):
    """(reality, nominal): arms and neck are bolted; the nominal one has no rotors. {joint: rotor inertia [kg m^2]}."""
    with open(MODEL) as file:
        text = file.read()
    text = re.sub(r'(?s)<joint name="((?:\w_(?:SHOULDER|ELBOW|WRIST|HAND)|NECK)\w*)" type="revolute">',
                  r'<joint name="\1" type="fixed">', text)
    rotors = {}
    for joint in re.finditer(r'(?s)<joint name="(\w+)" type="(\w+)">.*?</joint>', text):
        rotor = re.search(r'<rotor inertia="([\d.]+)"', joint[0])
        if rotor and joint[2] != 'fixed':
            rotors[joint[1]] = float(rotor[1])
    paths = []
    for name, urdf in (('reality', text), ('robot', re.sub(r'(?m)^\s*<rotor [^>]*/>\s*\n', '', text))):
        paths.append(os.path.join(run.out, name + '.urdf'))
        with open(paths[-1], 'w') as file:
            file.write(urdf)
    return paths, rotors


def list_leg_servos(text):
    """{joint: (kp, kd)} of a scenario."""
    return {m[1]: (float(m[2]), float(m[3])) for m in re.finditer(r'(?m)^    (\w+): \{kp: ([\d.]+), kd: ([\d.]+)\}', text)}


def write_table(run, name, log):
    """Of a log. The integrator's angular velocities are those of the middle of a step: a gyroscope at the step's end reads
    the mean of two of them."""
    path = os.path.join(run.out, name + '.csv')
    run.call(name, ['hrp-log', 'csv', log, '--out', path])
    with open(path) as file:
        names, *rows = [line.rstrip('\n').split(',') for line in file]
    gyro = [i for i, column in enumerate(names) if '/angular_velocity/' in column]
    lines = [names]
    for row, after in zip(rows, rows[1:]):
        lines.append(['%.9g' % (0.5 * (float(x) + float(after[i]))) if i in gyro else x for i, x in enumerate(row)])
    with open(path, 'w') as file:
        file.writelines(','.join(line) + '\n' for line in lines)


def record(run):
    """The recordings, the experiment that knows rigid feet and perfect joints only, and what was hidden."""
    text = drop(run.text('fig7'), 'contact', 'sensors', 'steps')
    text = re.sub(r'(?m)^    \w_(?:SHOULDER|ELBOW)\w*: .*\n|^    landing_speed: .*\n', '', text) + FLOOR
    (reality, nominal), rotors = write_robots(run)
    hidden = {'rotors': rotors, 'servos': list_leg_servos(text), 'bush': re.search(r'kz: .*', resimulate.get_section(text, 'foot_bush'))[0]}
    walks, count = (SHORT_WALKS, 2) if run.short else (WALKS, 6)
    entries = ''
    for name, step in walks:
        walk = re.sub(r'(?m)^robot: .*', 'robot: ' + reality, text) + NOISE + STEPS % (3.2 + 0.9 * count)
        walk = re.sub(r'plan: .*', 'plan: {count: %d, %s}' % (count, step), walk)
        log = os.path.join(run.out, name + '.mcap')
        run.serve(name, walk, run.vendors[0], log)
        write_table(run, name, log)
        entries += '  - {file: %s.csv, role: %s}\n' % (name, name.split('_')[0])
    known = re.sub(r'(?m)^robot: .*', 'robot: ' + nominal, drop(text, 'servo', 'foot_bush', 'interpolation', 'controller'))
    known += 'perfect_joints: true\n' + re.sub(r', (gyro|accelerometer|force|torque): \{[^}]*\}', '', NOISE).replace(
        re.search(r'  encoders: .*\n', NOISE)[0], '')
    return run.write('experiment', known + 'recordings:\n' + entries), hidden


def find(report, effect, place):
    """{place: {parameter: estimate}} of an effect's findings that are at least supported."""
    return {f['where'][place]: f['parameters'] for f in report['findings']
            if f['effect'] == effect and f['grade'] != 'ambiguous'}


def tell_soles(report, out, hidden):
    given = {k: float(v) for k, v in re.findall(r'(\w+): ([\d.e+]+)', hidden['bush'])}
    feet = find(report, 'foot_compliance', 'foot')
    out.claim('both soles are found', set(feet) == {'L_ANKLE_R_LINK', 'R_ANKLE_R_LINK'})
    worst = 0.0
    for foot, found in feet.items():
        for key in ('k_roll', 'k_pitch', 'c_roll', 'c_pitch', 'kz'):
            if key in found:
                p = found[key]
                out.number('%s %s' % (foot, key), '%.4g +- %.2g %s (given: %g)' % (p['value'], 1.96 * p['std'], p['unit'], given[key]))
                worst = max(worst, abs(p['value'] / given[key] - 1.0)) if key in ('k_roll', 'k_pitch') else worst
    out.claim('stiffness of the soles in roll and pitch within 5 %% (largest error %.2g %%)' % (100 * worst), feet and worst < 0.05)
    out.see('soles: stiffness within %.2g %%' % (100 * worst))


def tell_servos(report, out, hidden):
    servos = find(report, 'joint_servo', 'joint')
    legs = hidden['servos']
    errors = [abs(p['kp']['value'] / legs[j][0] - 1.0) for j, p in servos.items() if j in legs]
    for joint, p in servos.items():
        out.number('%s servo' % joint, 'kp %.5g +- %.2g N m/rad, kd %.4g +- %.2g N m s/rad (given: %g, %g)' % (
            p['kp']['value'], 1.96 * p['kp']['std'], p['kd']['value'], 1.96 * p['kd']['std'], *legs.get(joint, (0, 0))))
    out.claim('then that joints do not follow perfectly: servos of all %d leg joints (%d), stiffness within 5 %% (largest error '
              '%.2g %%)' % (len(legs), len(errors), 100 * max(errors, default=1.0)), len(errors) == len(legs) and max(errors) < 0.05)
    out.see('servos of %d of %d joints, stiffness within %.2g %%' % (len(errors), len(legs), 100 * max(errors, default=1.0)))


def tell_rotors(report, out, hidden, least):
    rotors, given = find(report, 'rotor_inertia', 'joint'), hidden['rotors']
    for joint, p in rotors.items():
        out.number('%s rotor' % joint, '%.3g +- %.2g kg m^2 (given: %g)' % (p['inertia']['value'], 1.96 * p['inertia']['std'], given.get(joint, 0.0)))
    values = {j: (p['inertia']['value'] / given[j] - 1.0, 1.96 * p['inertia']['std'] / given[j]) for j, p in rotors.items() if j in given}
    right = [abs(off) < max(0.1, interval) for off, interval in values.values()]
    worst = 100 * max((abs(off) for off, _ in values.values()), default=1.0)
    out.claim('and the rotors behind them: %d of %d joints (at least %d), within 10 %% or their interval (largest error %.2g %%)' % (
        len(right), len(given), least, worst), len(right) >= least and all(right))
    out.see('rotors of %d of %d joints, largest error %.2g %%' % (len(right), len(given), worst))
    others = [f['effect'] for f in report['findings'] if f['grade'] != 'ambiguous' and f['effect'] not in ('foot_compliance', 'joint_servo', 'rotor_inertia')]
    out.claim('no other effect is supported' + (': ' + ', '.join(others) if others else ''), not others)


def write_soles_only(folder):
    """The model between: what was found of the soles, joints that still follow perfectly. Figure 6."""
    updated = pathlib.Path(folder, 'updated')
    soles = [line for line in (updated / 'scenario.yaml').read_text().splitlines() if '"foot_compliance"' in line]
    path = updated / 'soles.yaml'
    path.write_text('\n'.join([(updated / 'nominal.yaml').read_text().rstrip('\n')] + (['effects:'] + soles if soles else [])) + '\n')
    return path


def walk_again(run, folder):
    """{model: (numbers, table)} of the held-out walk with the controller in the loop, and the recording's."""
    options = argparse.Namespace(bin=pathlib.Path(run.bin), out=pathlib.Path(folder), way='servers', experiment=None, wait=60.0,
                                 controller=os.path.join(run.out, 'validate_1.yaml'), only_check=False)
    result = resimulate.run(options, run.out)  # the nominal and the updated model, into the tool's own page
    controller = resimulate.make_controller(options)
    recorded, _ = resimulate.read_table(options.bin, os.path.join(run.out, 'validate_1.csv'), run.out)
    table, note = resimulate.simulate_closed(options, controller, write_soles_only(folder), controller.settings.read_text(),
                                             recorded, recorded['time'][-1], run.out)
    walk_figures.add_attitude(table)
    numbers = dict(result['walk']['numbers'], soles=walk_figures.measure(table, result['walk']['weight']))
    return result, numbers, table, note


def calc_power(numbers, which):
    """Power above 25 Hz of both feet over the recording's."""
    def add(name):
        return sum(f['rms_above_25_hz'] ** 2 for f in numbers[name]['feet'].values())
    return add(which) / add('recording')


def describe(numbers, which):
    run = numbers[which]
    if run['fall'] is not None:
        return 'falls at %.2f s' % run['fall']
    return 'upright, foot force above 25 Hz with %.3g times the power of the recording' % calc_power(numbers, which)


def tell_walks(run, out, folder):
    run.tell('the models walk with the controller in the loop')
    result, numbers, _, note = walk_again(run, folder)
    for which, words in (('nominal', 'rigid feet, perfect joints'), ('soles', 'with the soles that were found'),
                         ('updated', 'with soles, servos and rotors')):
        out.number('walked again, ' + words, describe(numbers, which))
    for which, words in (('nominal', 'the nominal model'), ('soles', 'with the soles alone (figure 6)')):
        off = numbers[which]['fall'] is not None or calc_power(numbers, which) > 10.0
        out.claim('%s does not walk like the recording: it falls, or shakes with ten times the power (%s)' % (
            words, describe(numbers, which)), off)
    updated, recorded = numbers['updated'], numbers['recording']
    out.claim('the updated model walks as in figure 7: upright, without the shaking (%s)' % describe(numbers, 'updated'),
              updated['fall'] is None and calc_power(numbers, 'updated') < 2.0)
    for foot, values in updated['feet'].items():
        for key, words in (('single_support', 'single support'), ('double_support', 'both feet')):
            here, there = values[key], recorded['feet'][foot][key]
            out.claim('%s, %s: %.0f N, recorded %.0f N (within 5 %%)' % (foot, words, here, there), abs(here / there - 1) < 0.05)
    nearer = [d for d in result['walk']['differences'] if d['nominal'] is not None and d['updated'] is not None]
    out.claim('every curve of the figures comes nearer to the recording (rms difference at most %.2g of the nominal\'s)' % max(
        d['updated'] / d['nominal'] for d in nearer), all(d['updated'] < d['nominal'] for d in nearer))
    for row in walk_report.list_rows(result['walk']):
        out.number(row[0], 'recording %s, nominal %s, updated %s' % tuple(row[1:]))
    out.see('walked again: nominal %s; soles alone %s; updated %s' % tuple(describe(numbers, w) for w in ('nominal', 'soles', 'updated')))
    if note:
        out.see(note)


STYLE = '.curve{fill:none;stroke-width:1.3}.recorded{stroke:#888;stroke-width:3}.before{stroke:#d0661a;stroke-dasharray:5 3}.after{stroke:#2b7fd0}'


def add_figures(run, out, folder):
    """As the paper draws them; the soles alone stand in place of the nominal model in the second one of a foot."""
    tables = {}
    recorded, _ = resimulate.read_table(pathlib.Path(run.bin), os.path.join(run.out, 'validate_1.csv'), run.out)
    for name in ('nominal', 'soles', 'scenario'):
        log = pathlib.Path(run.out, name + '_closed.mcap')
        tables[name], _ = resimulate.read_table(pathlib.Path(run.bin), log, run.out)
    for table in [recorded] + list(tables.values()):
        walk_figures.add_attitude(table)
    column = '/wrench/left_foot/force/z'
    for name, words in (('nominal', 'rigid feet, perfect joints'), ('soles', 'soft soles, perfect joints: figure 6'),
                        ('scenario', 'soft soles, servos and rotors: figure 7')):
        table = walk_report.until_fall(tables[name])
        svg = walk_figures.draw('Left foot, vertical force', 'N', [('recorded', recorded['time'], recorded[column]),
                                                                 ('after', table['time'], table[column])], recorded['time'][-1])
        out.figure('%s (blue) and the recording (grey).' % (words[0].upper() + words[1:]),
                   svg.replace('>', '><style>%s</style>' % html.escape(STYLE), 1))


def story(run, out):
    experiment, hidden = record(run)
    out.figure('What is recorded: a walk on soft soles.', run.pictures('train_1', os.path.join(run.out, 'train_1.mcap'), 2.0, 5.0))
    run.tell('the tool looks for what is missing')
    folder = os.path.join(run.out, 'diagnosis')
    run.call('diagnosis', ['hrp-diagnose', experiment, '--out', folder, '--quiet'])
    with open(os.path.join(folder, 'report.json')) as file:
        report = json.load(file)
    out.number('verdict', report['verdict'].replace('_', ' '))
    tell_soles(report, out, hidden)
    tell_servos(report, out, hidden)
    tell_rotors(report, out, hidden, 5 if run.short else 8)
    tell_walks(run, out, folder)
    add_figures(run, out, folder)
    out.number('the tool\'s own page', os.path.join(os.path.basename(run.out), 'diagnosis', 'report.html'))


EXPERIMENTS = [
    Experiment('story_walking', 'The same from walking alone',
               'Simulation on rigid feet with joints that follow perfectly walked, the robot did not; soft feet made the simulation '
               'fall or shake; joint servos and rotor inertia let it walk as the robot does (figures 3, 6, 7).',
               story, group='walking', cost=180.0)]
