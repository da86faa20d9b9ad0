#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Breaks each equation of docs/equations.md on purpose (a sign, an exponent, a term) and expects its test to fail.

Works on a copy of the project in build/mutations and builds one test program per equation there. What has been tried with the
same code and test is not tried again. Exit status 1 when a broken equation passes its test.

  scripts/mutate_equations.py               # all; the copy's first build takes minutes
  scripts/mutate_equations.py "H03 eq. 3"   # one equation
  scripts/mutate_equations.py --write       # also writes the table in docs/equations.md
  scripts/mutate_equations.py --check       # fast, a test: each place is there once, each row is broken somewhere
"""
import argparse
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check_equations import ROOT, read_rows  # noqa: E402

PAGE = ROOT / 'docs/equations.md'
HEAD = '| equation | in | broken so | its test |\n|---|---|---|---|\n'
WRENCH, POINTS, SPRING, PROJECTED = ('servers/dynamics/%s.cpp' % name for name in ('wrench_law', 'contact_law', 'spring_contact', 'spring_points'))
LIPM, IMPULSE = 'controller/walking/lipm.cpp', 'servers/dynamics/impulse_contact.cpp'
BODY, ROWS, FIT = ('diagnosis/identification/%s.cpp' % name for name in ('body_fit', 'bush_rows', 'bush_fit'))
REGRESSOR = 'common/multibody/regressor.cpp'

# (equation, file, what is there, what is put in its place); where an equation has several rows for a file: and the test's name
MUTATIONS = (
    ('H03 eq. 1', WRENCH, 'return -stiffness.cwiseProduct(D);', 'return stiffness.cwiseProduct(D);'),
    ('H03 eq. 1', WRENCH, 'return -stiffness.cwiseProduct(D);', 'return -stiffness.cwiseProduct(D.cwiseAbs2());'),
    ('H03 eq. 1', WRENCH, 'found.D = -rows.solve(', 'found.D = rows.solve(', 'MakesASpringWrenchOfForcesThatPushAtThePoints'),
    ('H03 eq. 1', POINTS, 'return {parameters.stiffness * depth, parameters.stiffness};', 'return {0.9 * parameters.stiffness * depth, parameters.stiffness};'),
    ('H03 eq. 2', 'servers/dynamics/twist_projection.cpp', '-speed_[i], -push_[i]);', '-speed_[i], -1e9);'),
    ('H03 eq. 2', 'servers/dynamics/twist_projection.cpp', 'r.cross(-n) / length_', 'r.cross(n) / length_'),
    ('H03 eq. 2', PROJECTED, 'point->pressing_offset = pressing + point->n.dot(point->v);', 'point->pressing_offset = pressing - point->n.dot(point->v);'),
    ('H03 eq. 3', WRENCH, 'array().pow(law.exponent)', 'array().pow(law.exponent + 1.0)'),
    ('H03 eq. 3', WRENCH, '1.5 * law.alpha', '1.0 * law.alpha'),
    ('H03 eq. 3', WRENCH, 'return -calc_damping_coefficients', 'return calc_damping_coefficients'),
    ('H03 eq. 3', POINTS, 'std::pow(depth, parameters.exponent));', 'std::pow(depth, parameters.exponent - 1.0));'),
    ('H03 eq. 3', 'servers/dynamics/contact_law.h', 'return 1.5 * alpha * stiffness;', 'return 1.5 * stiffness;'),
    ('H03 eq. 4', WRENCH, 'return spring + damper;', 'return spring - damper;'),
    ('H03 eq. 4', WRENCH, 'return spring + damper;', 'return spring;'),
    ('H03 eq. 5', WRENCH, 'Matrix6d::Identity() - n * n.transpose() / square;', 'Matrix6d::Identity();'),
    ('H03 eq. 5', WRENCH, 'return -calc_tangential_slope(law, normal) * V;', 'return calc_tangential_slope(law, normal) * V;'),
    ('H03 eq. 5', 'servers/dynamics/contact_law.h', 'slip + parameters.tangential_damping * velocity', 'slip - parameters.tangential_damping * velocity'),
    ('H03 eq. 5', SPRING, 'const Vector3d tangential = remove_normal(point.n, v);\n  return calc_tangential_force(', 'const Vector3d tangential = v;\n  return calc_tangential_force('),
    ('H03 eq. 6', WRENCH, 'const double limit = friction * calc_wrench_norm(length, normal);', 'const double limit = calc_wrench_norm(length, normal);'),
    ('H03 eq. 6', WRENCH, '*tangential *= limit / size;', '*tangential *= 0.5 * limit / size;'),
    ('H03 eq. 6', WRENCH, 'const double size = calc_wrench_norm(length, *tangential);', 'const double size = tangential->tail<3>().norm();'),
    ('H03 eq. 6', POINTS, '*tangential *= limit / length;', '*tangential *= length / limit;'),
    ('H03 eq. 6', SPRING, 'point->direction = trial / length;', 'point->direction = -trial / length;'),
    ('H03 eq. 7', 'controller/walking/lipm.h', 'return kx * x.x() + ky * x.y();', 'return kx * x.x() - ky * x.y();'),
    ('H03 eq. 7', 'controller/walking/lipm.h', 'return kx * x.x() + ky * x.y();', 'return -kx * x.x() + ky * x.y();'),
    ('H03 eq. 8', LIPM, 'p0 + rate * t + C * dx + Tc * S * dv', 'p0 + rate * t + C * dx - Tc * S * dv'),
    ('H03 eq. 8', LIPM, 'start.x - p0', 'start.x + p0'),
    ('H03 eq. 9', LIPM, 'return std::sqrt(zc / g);', 'return std::sqrt(g / zc);'),
    ('H03 eq. 9', LIPM, 'rate + S / Tc * dx + C * dv', 'rate + S * Tc * dx + C * dv'),
    ('H03 section 2.1.4', 'controller/walking/stabilizer.cpp', 'return clamp(-(spec.inclination_gain', 'return clamp((spec.inclination_gain'),
    ('H03 section 2.1.4', 'controller/walking/stabilizer.cpp', 'dt * (spec.zmp_gain * zmp_error', 'dt * (-spec.zmp_gain * zmp_error'),
    ('H03 section 3.1', IMPULSE, '-options_.restitution * speed', 'options_.restitution * speed', 'ReboundsWithTheImpulseModelsRestitution'),
    ('H03 section 3.1', IMPULSE, 'point.P[0] = std::max(0.0, point', 'point.P[0] = (0.0 + point', 'IsNotHeldByImpulses'),
    ('M14 eq. 1', REGRESSOR, 'skew(alpha) + W * W;', 'skew(alpha) - W * W;'),
    ('M14 eq. 1', REGRESSOR, '= -skew(acc);', '= skew(acc);'),
    ('M14 eq. 1', REGRESSOR, 'qd, sign(qd);', 'qd, 1.0;'),
    ('M14 eq. 2', 'common/multibody/base_parameters.cpp', 'base.T.col(c) = solver.solve(R.col(c));', 'base.T.col(c) = -solver.solve(R.col(c));'),
    ('M14 eq. 2', BODY, 's.theta = s.inverse * s.b;', 's.theta = -(s.inverse * s.b);'),
    ('M14 eq. 3', BODY, '+ m.exerted(6 + i, k)', '- m.exerted(6 + i, k)'),
    ('M14 eq. 3', BODY, '- Y.Y_JI.row(i).dot(phi);', '+ Y.Y_JI.row(i).dot(phi);'),
    ('M14 eq. 4', ROWS, 'theta[at] * c.angle + theta[at + 1] * c.rate', 'theta[at] * c.angle - theta[at + 1] * c.rate'),
    ('M14 eq. 4', ROWS, 'torque.array() += theta[at + 2];', 'torque.array() -= theta[at + 2];'),
    ('M14 eq. 5', ROWS, 'X.col(at + 1) = c.rate;', 'X.col(at + 1) = -c.rate;'),
    ('M14 eq. 5', ROWS, 'X.col(at + 2).setOnes();', 'X.col(at + 2).setZero();'),
    ('M14 eq. 6', FIT, 'theta = solve_signed(normal.A, normal.b,', 'theta = solve_signed(normal.A, -normal.b,'),
    ('M14 eq. 7', FIT, 'normal.b.noalias() += weight', 'normal.b.noalias() = weight'),
    ('M14 eq. 7', FIT, 'm < tracks.size(); ++m', 'm < 1; ++m'),
)


def find_row(mutation, rows):
    """The row whose test must fail: of the same equation, with the broken file or its header before others."""
    equation, file, name = mutation[0], mutation[1], ''.join(mutation[4:])
    fitting = [cells for _, cells in rows if ' '.join(cells[:2]) == equation and cells[4].endswith(name)]
    stem = file.rsplit('.', 1)[0]
    return next((cells for cells in fitting if cells[3].rsplit('.', 1)[0] == stem), fitting[0] if fitting else None)


def split_test(cell):
    """(file, program, filter of googletest) of 'tests/physics/x_test.cpp: Name'."""
    file, _, name = (part.strip() for part in cell.partition(':'))
    return file, pathlib.Path(file).stem, '*.%s*' % name


def check(rows):
    faults = []
    broken = {mutation[0] for mutation in MUTATIONS}
    for mutation in MUTATIONS:
        equation, file, old, new = mutation[:4]
        count = (ROOT / file).read_text().count(old)
        if count != 1:
            faults.append('%s: %s has %r %d times, expected once' % (equation, file, old, count))
        if old == new or find_row(mutation, rows) is None:
            faults.append('%s: nothing is broken, or docs/equations.md has no such row' % equation)
    for number, cells in rows:
        if ' '.join(cells[:2]) not in broken:
            faults.append('docs/equations.md:%d: %s is broken nowhere in scripts/mutate_equations.py' % (number, ' '.join(cells[:2])))
    for line in make_table(rows, None).splitlines():
        if line.startswith('| H03') or line.startswith('| M14'):
            if line.rsplit('|', 2)[0] not in PAGE.read_text():
                faults.append('docs/equations.md lacks the row %s; use --write' % line)
    return faults


def copy_project(scratch):
    """Only what differs, so that the copy's build stays what it is."""
    listed = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        source, target = ROOT / name, scratch / name
        if source.is_file() and not (target.is_file() and target.read_bytes() == source.read_bytes()):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)


def build(scratch, program):
    done = subprocess.run(['ninja', '-C', str(scratch / 'build'), program], capture_output=True, text=True)
    return '' if done.returncode == 0 else done.stdout[-2000:]


def passes(scratch, program, words):
    done = subprocess.run([str(scratch / 'build/tests' / program), '--gtest_filter=' + words], cwd=scratch,
                          capture_output=True, text=True, timeout=900)
    if 'Running 0 tests' in done.stdout:
        sys.exit('%s has no test %s' % (program, words))
    return done.returncode == 0


def try_mutation(scratch, mutation, row):
    """'fails', as it should, or what happened instead."""
    _, file, old, new = mutation[:4]
    _, program, words = split_test(row[4])
    target, text = scratch / file, (ROOT / file).read_text()
    try:
        if build(scratch, program) or not passes(scratch, program, words):
            return 'FAILS WITHOUT ANYTHING BROKEN'
        target.write_text(text.replace(old, new))
        if build(scratch, program):
            return 'DOES NOT COMPILE'
        return 'PASSES' if passes(scratch, program, words) else 'fails'
    finally:
        target.write_text(text)


def make_key(mutation, row):
    texts = [(ROOT / mutation[1]).read_text(), (ROOT / split_test(row[4])[0]).read_text(), repr(mutation), row[4]]
    return hashlib.sha256('\0'.join(texts).encode()).hexdigest()[:20]


def shorten(code):
    return '`%s`' % re.sub(r'\s+', ' ', code).strip().replace('|', '\\|')


def make_table(rows, results):
    lines = []
    for mutation in MUTATIONS:
        row = find_row(mutation, rows)
        what = results.get(make_key(mutation, row), 'not tried') if results is not None else ''
        lines.append('| %s | %s | %s becomes %s | %s %s |' % (
            mutation[0], mutation[1].rsplit('/', 1)[1], shorten(mutation[2]), shorten(mutation[3]),
            row[4].partition(':')[2].strip(), what))
    return HEAD + '\n'.join(lines) + '\n'


def write_page(rows, results):
    text, begin, end = PAGE.read_text(), '<!-- mutations -->\n', '<!-- end of mutations -->\n'
    head, _, rest = text.partition(begin)
    PAGE.write_text(head + begin + '\n' + make_table(rows, results) + '\n' + end + rest.partition(end)[2])


def prepare(scratch):
    scratch.mkdir(parents=True, exist_ok=True)
    copy_project(scratch)
    if not (scratch / 'build/build.ninja').is_file():
        subprocess.run(['cmake', '-S', str(scratch), '-B', str(scratch / 'build'), '-G', 'Ninja', '-DCMAKE_BUILD_TYPE=Release',
                        '-DBUILD_TESTING=ON', '-DHRP_RUN_ONLY=OFF'], check=True, stdout=subprocess.DEVNULL)


def run(options, rows):
    scratch, store = options.scratch, options.scratch / 'results.json'
    prepare(scratch)
    results = json.loads(store.read_text()) if store.is_file() else {}
    wrong = 0
    for mutation in MUTATIONS:
        row = find_row(mutation, rows)
        key = make_key(mutation, row)
        if options.equations and mutation[0] not in options.equations:
            continue
        if results.get(key) != 'fails':
            results[key] = try_mutation(scratch, mutation, row)
            store.write_text(json.dumps(results))
        wrong += results[key] != 'fails'
        print('%-18s %-14s %s: %s -> %s' % (mutation[0], results[key], mutation[1], *map(shorten, mutation[2:4])), flush=True)
    if options.write:
        write_page(rows, results)
    print('%d broken equations pass their tests' % wrong)
    return 1 if wrong else 0


def read_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('equations', nargs='*', metavar='EQUATION', help='"H03 eq. 3"; default: all')
    parser.add_argument('--check', action='store_true', help='only whether the list fits the code; builds nothing')
    parser.add_argument('--write', action='store_true', help='writes the table in docs/equations.md')
    parser.add_argument('--scratch', type=pathlib.Path, default=ROOT / 'build/mutations', metavar='DIR')
    return parser.parse_args()


def main():
    options, rows = read_options(), list(read_rows(PAGE))
    if not options.check:
        return run(options, rows)
    faults = check(rows)
    print('\n'.join(faults) if faults else '%d mutations, all in place' % len(MUTATIONS))
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
