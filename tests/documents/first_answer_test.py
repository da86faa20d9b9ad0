#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The first answer that the README shows is the one of the table of real recordings, which a script writes.

    first_answer_test.py SOURCE
"""
import pathlib
import re
import sys

SOURCE = pathlib.Path(sys.argv[1]).resolve()


def find_rows(page, start):
    return [line for line in (SOURCE / page).read_text().splitlines() if line.startswith(start)]


def find_numbers(text):
    return set(re.findall(r'\d+\.\d+', text))


readme = (SOURCE / 'README.md').read_text()
answer = readme[readme.index('| found | grade | value |'):].split('\n\n')[0]
recording = re.search(r'\(`(\w+)` in \[recordings\]', readme).group(1)
rows = find_rows('docs/recordings.md', '| %s |' % recording)
assert len(rows) >= 3, 'docs/recordings.md has %d rows of %s, expected its findings and two errors' % (len(rows), recording)
unknown = find_numbers(answer) - find_numbers('\n'.join(rows))
if unknown:
    sys.exit('README.md: %s of the first answer stand in no row of %s in docs/recordings.md' % (', '.join(sorted(unknown)), recording))
for grade in ('supported', 'ambiguous'):
    if ('| %s |' % grade in answer) and '(%s)' % grade not in rows[0]:
        sys.exit('README.md: docs/recordings.md has no %s finding of %s' % (grade, recording))
print('%d numbers of the first answer are those of docs/recordings.md' % len(find_numbers(answer)))
