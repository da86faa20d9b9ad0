# SPDX-License-Identifier: BSD-3-Clause
"""What is known of a sweep's runs: a line a run as soon as it is done (results.jsonl), and the table (table.csv)."""
import csv
import io
import json
import os

from sweep_yaml import BadSweep

OUTCOMES = ['status', 'fallen', 'fall_time', 'duration', 'largest_lean', 'travelled_x', 'travelled_y', 'travelled_z', 'turned',
            'landings', 'state_hash', 'fault']


class Journal:
    """Survives a kill at any time: a line that was cut off counts for nothing."""

    def __init__(self, folder):
        os.makedirs(folder, exist_ok=True)
        self.path, self.done = os.path.join(folder, 'results.jsonl'), {}
        if os.path.exists(self.path):
            self.read()
        self.file = open(self.path, 'a')

    def read(self):
        with open(self.path, 'rb') as file:
            content = file.read()
        whole = content[:content.rfind(b'\n') + 1]
        if whole != content:
            with open(self.path, 'wb') as file:
                file.write(whole)
        for number, line in enumerate(whole.splitlines(), 1):
            try:
                entry = json.loads(line)
                # Done again: what was killed, what may have been mended meanwhile, what may have more time now.
                if entry['result']['status'] not in ('killed', 'refused', 'too_long'):
                    self.done[entry['key']] = entry
            except (ValueError, TypeError, KeyError):
                raise BadSweep('%s:%d: is no result of a sweep; name another folder' % (self.path, number)) from None

    def add(self, entry):
        self.done[entry['key']] = entry
        self.file.write(json.dumps(entry) + '\n')
        self.file.flush()
        os.fsync(self.file.fileno())

    def close(self):
        self.file.close()


def write_whole(path, text):
    """The file is the old one or the new one, never half of one."""
    with open(path + '.new', 'w') as file:
        file.write(text)
    os.replace(path + '.new', path)


def make_rows(runs, done):
    """Of all runs that are done, in the order of the sweep: no trace of who did them and when."""
    return [{'run': number, **run['columns'], **{k: v for k, v in done[run['key']]['result'].items() if k in OUTCOMES}}
            for number, run in enumerate(runs, 1) if run['key'] in done]


def make_csv(runs, rows):
    names = ['run'] + list(runs[0]['columns']) + OUTCOMES
    out = io.StringIO()
    writer = csv.DictWriter(out, names, restval='', lineterminator='\n')
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()
