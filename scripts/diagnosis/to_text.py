#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes a recording of NumPy, MATLAB, HDF5, JSON, or text with lists in its cells as a text recording, for the diagnosis.

to_text.py RECORDING [--out RECORDING.csv] [--force]

  .npz, .npy    NumPy; a table of records, too
  .mat          MATLAB, up to 7.2 (python3-scipy) and 7.3 (python3-h5py); structures, too
  .h5, .hdf5    HDF5 (python3-h5py)
  .json, .jsonl JSON: lists of numbers by name, or a list of records, or a record on each line
  .csv, .txt    text whose cells hold lists, such as "[0.1, 0.2]"; becomes RECORDING.columns.csv

Each array that has one value, or one row, for each sample becomes one or more columns: q with seven values a sample becomes
q_0 to q_6 (of MATLAB q_1 to q_7). Single numbers stand in comments at the head of the file. What has another length, or is no
number, is left out, and named. So is the last line of a recorder that was killed. A sample without a value gets nan.
"""
import argparse
import collections
import csv
import json
import pathlib
import re
import sys

import numpy as np

LEAST_SAMPLES = 10  # shorter arrays hold settings
DATE = re.compile(r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d+)?) ?(?:Z|[+-]\d\d:?\d\d)?")  # a zone is the same in all samples


class Refused(Exception):
    """What is wrong with the file, for people."""


def need(module, package):
    try:
        return __import__(module, fromlist=["x"])
    except ImportError:
        raise Refused(f"needs {module}: apt-get install {package}") from None


def read_numpy(path, left):
    try:
        loaded = np.load(path, allow_pickle=False)
    except ValueError as error:
        raise Refused(f"{error}; save plain arrays of numbers, not objects") from None
    if not isinstance(loaded, np.ndarray):
        return dict(loaded)
    return loaded if loaded.dtype.names else {path.stem: loaded}


def read_hdf5(path, left):
    found = {}
    with need("h5py", "python3-h5py").File(path, "r") as file:
        file.visititems(lambda name, item: found.update({name.replace("/", "."): item[()]}) if hasattr(item, "shape") else None)
    return found


def read_matlab(path, left):
    with open(path, "rb") as file:
        if file.read(10) == b"MATLAB 7.3":
            return read_hdf5(path, left)  # a container of HDF5
    loaded = need("scipy.io", "python3-scipy").loadmat(path, simplify_cells=True)
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def read_values(values):
    """An array of numbers or dates; of nothing where there are words, or lists of several lengths."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        pass
    if not isinstance(values, list):
        return np.asarray("")
    dates = [DATE.fullmatch(value) if isinstance(value, str) else None for value in values]
    if all(dates):
        return np.asarray([date[1] for date in dates], dtype="datetime64[ns]")
    lengths = {len(value) for value in values if isinstance(value, list)}
    if len(lengths) != 1 or None not in values:
        return np.full(len(values), "")
    nothing = [None] * lengths.pop()  # of a sample without a list
    return read_values([nothing if value is None else value for value in values])


def unfold(value):
    """Arrays by name, of records or of lists of records. None where a record has no such name."""
    if isinstance(value, dict):
        return {name: unfold(part) for name, part in value.items()}
    if isinstance(value, list) and any(isinstance(record, dict) for record in value) and all(isinstance(record, (dict, type(None))) for record in value):
        records = [record or {} for record in value]
        names = dict.fromkeys(name for record in records for name in record)  # a set in their order
        return {name: unfold([record.get(name) for record in records]) for name in names}
    return read_values(value)


def read_lines(text, left):
    """The record of each line; nothing if the first one is none. A last line that is cut off is left out."""
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    records = []
    for number, line in lines:
        try:
            records.append(json.loads(line))
        except ValueError as error:
            if records and number != lines[-1][0]:
                raise Refused(f"line {number} is no JSON: {error.msg} at character {error.pos + 1}") from None
            left.append(f"line {number} (cut off)")
            break
    return records


def read_json(path, left):
    text = path.read_text(encoding="utf-8-sig")
    try:
        loaded = json.loads(text)
    except ValueError as error:
        loaded = read_lines(text, left)
        if not loaded:
            raise Refused(f"is no JSON: {error}") from None
    unfolded = unfold(loaded)
    return unfolded if isinstance(unfolded, dict) else {path.stem: unfolded}


def read_cell(text):
    """What a number, or each of several between brackets, is written as; commas, semicolons or spaces separate them. None: nothing."""
    if not text or not text.lstrip().startswith(("[", "(")):
        return text or None
    return [number for number in re.split(r"[\s,;]+", text.strip(" \t[]()")) if number]


def read_lists(path, left):
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file, skipinitialspace=True))
    if not any("[" in cell or "(" in cell for cell in (rows[0].values() if rows else ()) if isinstance(cell, str)):
        raise Refused("has no lists in its cells: the diagnosis reads it as it is")
    names = [name for name in rows[0] if name is not None]  # None: cells beyond the header
    last = [rows[-1][name] for name in names]
    if None in last or last[-1].count("[") > last[-1].count("]") or last[-1].count("(") > last[-1].count(")"):
        rows.pop()
        left.append("the last line (cut off)")
    return {name: unfold([read_cell(row[name]) for row in rows]) for name in names}


READERS = {".npz": read_numpy, ".npy": read_numpy, ".mat": read_matlab, ".h5": read_hdf5, ".hdf5": read_hdf5, ".json": read_json, ".jsonl": read_json,
           ".csv": read_lists, ".txt": read_lists}


def flatten(name, value, found, left):
    """Arrays of numbers below `value`, by dotted names."""
    if isinstance(value, dict):
        for key, part in value.items():
            flatten(f"{name}.{key}" if name else str(key), part, found, left)
        return
    array = np.asarray(value)
    if array.dtype.names:
        for field in array.dtype.names:
            flatten(f"{name}.{field}" if name else field, array[field], found, left)
    elif array.dtype.kind == "M":
        found[name] = array.astype("datetime64[ns]").astype(np.int64) * 1e-9
    elif array.dtype.kind in "biuf":
        found[name] = np.squeeze(array).astype(float)
    elif array.ndim > 0:
        left.append(f"{name} (words, or lists of several lengths)")


def find_samples(arrays):
    """How many samples the recording has: the length that most arrays have; of equally many, the largest."""
    counts = collections.Counter()
    for array in arrays.values():
        counts.update({length for length in array.shape if length >= LEAST_SAMPLES} if array.ndim in (1, 2) else ())
    if not counts:
        raise Refused(f"has no array of {LEAST_SAMPLES} samples or more")
    return max(counts, key=lambda length: (counts[length], length))


def make_name(name):
    """Without what would end a cell or a line of the text, or make a comment of it."""
    return re.sub(r'[,;"\s]', "_", name).lstrip("#%") or "_"


def make_columns(arrays, samples, first, left):
    """Columns by name. `first`: number of the first of several columns."""
    columns = {}
    for name, array in arrays.items():
        rows = array.T if array.ndim == 2 and array.shape[0] != samples else array  # or a row of samples for each signal
        if rows.ndim not in (1, 2) or rows.shape[0] != samples:
            left += [f"{name} ({' x '.join(map(str, array.shape))})"] if array.ndim > 0 else []
            continue
        parts = {name: rows} if rows.ndim == 1 else {f"{name}_{first + i}": rows[:, i] for i in range(rows.shape[1])}
        for part, values in parts.items():
            if make_name(part) in columns:
                left.append(f"{part} (this name stands twice)")
            columns.setdefault(make_name(part), values)
    return {f"column_{name}" if re.fullmatch(r"[\d.+-]+", name) else name: values for name, values in columns.items()}  # a header has words


def convert(source, target):
    """Writes the file. Returns what to tell people."""
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise Refused(f"is of no kind that is read here: expected {', '.join(READERS)}")
    arrays, left = {}, []
    try:
        flatten("", reader(source, left), arrays, left)
    except Refused:
        raise
    except Exception as error:  # whatever a library throws at bytes that make no sense
        raise Refused(f"cannot be read: {error}") from None
    samples = find_samples(arrays)
    columns = make_columns(arrays, samples, 1 if source.suffix.lower() == ".mat" else 0, left)
    settings = [f"{name} = {array:.17g}" for name, array in arrays.items() if array.ndim == 0]
    write(target, settings, columns)
    told = [f"{target}: {samples} samples of {len(columns)} signals"]
    told += [f"  single numbers: {', '.join(settings)}"] if settings else []
    return told + ([f"  left out: {', '.join(left)}"] if left else [])


def write(target, settings, columns):
    try:
        with open(target, "w", encoding="utf-8") as file:
            file.writelines("# " + " ".join(setting.split()) + "\n" for setting in settings)
            file.write(",".join(columns) + "\n")
            np.savetxt(file, np.column_stack(list(columns.values())), fmt="%.17g", delimiter=",")
    except OSError as error:
        raise Refused(f"{target} cannot be written: {error.strerror}") from None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, help="default: the recording's name with .csv, or .columns.csv if it is text")
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")
    arguments = parser.parse_args()
    source = arguments.recording
    is_text = READERS.get(source.suffix.lower()) is read_lists
    target = arguments.out or source.with_suffix(".columns.csv" if is_text else ".csv")
    try:
        if not source.is_file():
            raise Refused("no such file")
        if target.exists() and not arguments.force:
            raise Refused(f"{target} exists; --force overwrites it, --out names another file")
        print("\n".join(convert(source, target)))
    except Refused as reason:
        sys.exit(f"{source}: error: {reason}")


if __name__ == "__main__":
    main()
