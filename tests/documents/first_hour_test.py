#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""first_hour_test.py SOURCE BUILD: every test that docs/first_hour.md names is in the suite, and every claim behind it
(Suite.Test, or Suite) in that test's source."""
import json
import pathlib
import re
import subprocess
import sys

SOURCE, BUILD = (pathlib.Path(p).resolve() for p in sys.argv[1:3])


def find_registered():
    listed = subprocess.run(['ctest', '-C', 'nightly', '--show-only=json-v1'], cwd=BUILD, capture_output=True, text=True, check=True)
    return {test['name'] for test in json.loads(listed.stdout)['tests']}


def find_claims(cell):
    """`test` Claim.One, Claim.Two, `other` ... -> (test, [claims])."""
    for test, claims in re.findall(r'`([\w-]+)`([^`]*)', cell):
        yield test, re.findall(r'[\w.]+', claims)


def is_claimed(source, claim):
    suite, _, name = claim.partition('.')
    return re.search(r'\b(TEST|TEST_F|TEST_P)\(%s, %s\b' % (suite, name or r'\w+'), source) is not None


def main():
    registered, faults, count = find_registered(), [], 0
    sources = {path.stem: path.read_text() for path in (SOURCE / 'tests').rglob('*_test.cpp')}
    for number, line in enumerate((SOURCE / 'docs/first_hour.md').read_text().splitlines(), 1):
        cells = line.split('|')
        if len(cells) != 4 or cells[2].strip() in ('test', '---'):
            continue
        for test, claims in find_claims(cells[2]):
            count += 1 + len(claims)
            if test not in registered:
                faults.append(f'docs/first_hour.md:{number}: there is no test {test}')
            faults += [f'docs/first_hour.md:{number}: {test} has no {claim}' for claim in claims if not is_claimed(sources.get(test, ''), claim)]
    print('\n'.join(faults) if faults else f'{count} tests and claims, all there')
    return 1 if faults or not count else 0


if __name__ == '__main__':
    sys.exit(main())
