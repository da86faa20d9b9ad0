#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""readable_documents_test.py SOURCE: sentences of README and docs are short enough for readers who scan."""
import pathlib
import re
import statistics
import sys

SOURCE = pathlib.Path(sys.argv[1]).resolve()
MEDIAN, NINE_OF_TEN = 15, 30  # words
README_LINES = 120
FEW = 12  # sentences that tell nothing about a page


def find_sentences(text):
    """Words of each sentence of running text: no blocks, tables or headings. A piece of code is one word."""
    text = re.sub(r'^```.*?^```', '', text, flags=re.M | re.S)
    for paragraph in re.split(r'\n\s*\n|\n(?=[-|#*]|\d+\. )', text):
        paragraph = paragraph.strip()
        if not paragraph or paragraph[0] in '|#!<':
            continue
        paragraph = re.sub(r'`[^`]*`', 'code', re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', paragraph)).replace('\n', ' ')
        for sentence in re.split(r'(?<=[.:?!])\s+', paragraph):
            words = [word for word in sentence.split() if re.search(r'\w', word)]
            if len(words) > 2:
                yield words


def find_faults(path):
    lengths = sorted(len(words) for words in find_sentences(path.read_text()))
    if len(lengths) < FEW:
        return
    if statistics.median(lengths) > MEDIAN:
        yield f'{path}: half of its sentences have more than {MEDIAN} words'
    if lengths[int(0.9 * len(lengths))] > NINE_OF_TEN:
        yield f'{path}: more than one sentence in ten has more than {NINE_OF_TEN} words'


def main():
    pages = [SOURCE / 'README.md', SOURCE / 'idl/README.md'] + sorted((SOURCE / 'docs').rglob('*.md'))
    faults = [fault for page in pages for fault in find_faults(page)]
    lines = len((SOURCE / 'README.md').read_text().splitlines())
    if lines > README_LINES:
        faults.append(f'README.md has {lines} lines, more than {README_LINES}')
    print('\n'.join(faults) if faults else f'{len(pages)} pages can be read')
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
