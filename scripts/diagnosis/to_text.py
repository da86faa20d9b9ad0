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
q_0 to q_6 (of MATLAB q_1 to q_7). Single numbers stand in comments at the head of the file. What has another length is left
out, and named.
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


class Refused(Exception):
    """What is wrong with the file, for people."""


def need(module, package):
    try:
        return __import__(module, fromlist=["x"])
    except ImportError:
        raise Refused(f"needs {module}: apt-get install {package}") from None


def read_numpy(path):
    try:
        loaded = np.load(path, allow_pickle=False)
    except ValueError as error:
        raise Refused(f"{error}; save plain arrays of numbers, not objects") from None
    if not isinstance(loaded, np.ndarray):
        return dict(loaded)
    return loaded if loaded.dtype.names else {path.stem: loaded}


def read_hdf5(path):
    found = {}
    with need("h5py", "python3-h5py").File(path, "r") as file:
        file.visititems(lambda name, item: found.update({name.replace("/", "."): item[()]}) if hasattr(item, "shape") else None)
    return found


def read_matlab(path):
    with open(path, "rb") as file:
        if file.read(10) == b"MATLAB 7.3":
            return read_hdf5(path)  # a container of HDF5
    loaded = need("scipy.io", "python3-scipy").loadmat(path, simplify_cells=True)
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def unfold(value):
    """Records of arrays, of lists of records; empty where there are words, or lists of several lengths."""
    if isinstance(value, dict):
        return {name: unfold(part) for name, part in value.items()}
    if isinstance(value, list) and value and all(isinstance(record, dict) for record in value):
        return {name: unfold([record[name] for record in value]) for name in value[0] if all(name in record for record in value)}
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return np.asarray("")


def read_json(path):
    text = path.read_text(encoding="utf-8")
    try:
        loaded = json.loads(text)
    except ValueError:
        loaded = [json.loads(line) for line in text.splitlines() if line.strip()]
    unfolded = unfold(loaded)
    return unfolded if isinstance(unfolded, dict) else {path.stem: unfolded}


def read_cell(text):
    """What a number, or each of several between brackets, is written as; commas, semicolons or spaces separate them."""
    if not text or not text.lstrip().startswith(("[", "(")):
        return text or "nan"
    return [number for number in re.split(r"[\s,;]+", text.strip(" \t[]()")) if number]


def read_lists(path):
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file, skipinitialspace=True))
    if not any("[" in cell or "(" in cell for cell in (rows[0].values() if rows else ()) if isinstance(cell, str)):
        raise Refused("has no lists in its cells: the diagnosis reads it as it is")
    return {name: unfold([read_cell(row[name]) for row in rows]) for name in rows[0] if name is not None}  # None: cells beyond the header


READERS = {".npz": read_numpy, ".npy": read_numpy, ".mat": read_matlab, ".h5": read_hdf5, ".hdf5": read_hdf5, ".json": read_json, ".jsonl": read_json,
           ".csv": read_lists, ".txt": read_lists}


def flatten(name, value, found):
    """Arrays of numbers below `value`, by dotted names."""
    if isinstance(value, dict):
        for key, part in value.items():
            flatten(f"{name}.{key}" if name else str(key), part, found)
        return
    array = np.asarray(value)
    if array.dtype.names:
        for field in array.dtype.names:
            flatten(f"{name}.{field}" if name else field, array[field], found)
    elif array.dtype.kind == "M":
        found[name] = array.astype("datetime64[ns]").astype(np.int64) * 1e-9
    elif array.dtype.kind in "biuf":
        found[name] = np.squeeze(array).astype(float)


def find_samples(arrays):
    """How many samples the recording has: the length that most arrays have; of equally many, the largest."""
    counts = collections.Counter()
    for array in arrays.values():
        counts.update({length for length in array.shape if length >= LEAST_SAMPLES} if array.ndim in (1, 2) else ())
    if not counts:
        raise Refused(f"has no array of {LEAST_SAMPLES} samples or more")
    return max(counts, key=lambda length: (counts[length], length))


def make_columns(arrays, samples, first):
    """(columns by name, names of what is left out). `first`: number of the first of several columns."""
    columns, left = {}, []
    for name, array in arrays.items():
        if array.ndim == 2 and array.shape[0] != samples:
            array = array.T  # a row of samples for each signal
        if array.ndim == 1 and array.shape[0] == samples:
            columns[name] = array
        elif array.ndim == 2 and array.shape[0] == samples:
            columns.update({f"{name}_{first + i}": array[:, i] for i in range(array.shape[1])})
        elif array.ndim > 0:
            left.append(f"{name} ({' x '.join(map(str, array.shape))})")
    return columns, left


def convert(source, target):
    """Writes the file. Returns what to tell people."""
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise Refused(f"is of no kind that is read here: expected {', '.join(READERS)}")
    arrays = {}
    try:
        flatten("", reader(source), arrays)
    except Refused:
        raise
    except Exception as error:  # whatever a library throws at bytes that make no sense
        raise Refused(f"cannot be read: {error}") from None
    samples = find_samples(arrays)
    columns, left = make_columns(arrays, samples, 1 if source.suffix.lower() == ".mat" else 0)
    settings = [f"{name} = {array:.17g}" for name, array in arrays.items() if array.ndim == 0]
    with open(target, "w", encoding="utf-8") as file:
        file.writelines(f"# {setting}\n" for setting in settings)
        file.write(",".join(columns) + "\n")
        np.savetxt(file, np.column_stack(list(columns.values())), fmt="%.17g", delimiter=",")
    told = [f"{target}: {samples} samples of {len(columns)} signals"]
    told += [f"  single numbers: {', '.join(settings)}"] if settings else []
    return told + ([f"  left out, because they have other lengths: {', '.join(left)}"] if left else [])


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
