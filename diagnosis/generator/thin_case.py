#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""thin_case.py CASE OUT RECORDING[,RECORDING...] STEP: a case of hrp-make-cases, made small enough to be shipped.

Keeps the named recordings, every STEP-th sample and six significant digits of each reading.
"""
import shutil
import sys
from pathlib import Path


def thin_experiment(text, recordings, step):
    lines = []
    for line in text.splitlines():
        if '- {file:' in line and not any(f'{name}.csv' in line for name in recordings):
            continue
        if line.startswith('sample_rate:'):
            line = f'sample_rate: {float(line.split(":")[1]) / step:g}'
        lines.append(line)
    return '\n'.join(lines) + '\n'


def thin_recording(text, step):
    head, *rows = text.splitlines()
    kept = [','.join(f'{float(cell):.6g}' if cell else '' for cell in row.split(',')) for row in rows[::step]]
    return '\n'.join([head, *kept]) + '\n'


def main(case, out, names, step):
    case, out, recordings, step = Path(case), Path(out), names.split(','), int(step)
    out.mkdir(parents=True, exist_ok=True)
    (out / 'experiment.yaml').write_text(thin_experiment((case / 'experiment.yaml').read_text(), recordings, step))
    shutil.copy(case / 'robot.urdf', out)
    for name in recordings:
        (out / f'{name}.csv').write_text(thin_recording((case / f'{name}.csv').read_text(), step))


if __name__ == '__main__':
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
