#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes an experiment's CSV recordings as ROS 2 bags (rosbag2, storage sqlite3), for the tutorial and for tests.

make_bag.py EXPERIMENT_FOLDER --out DIR

DIR/experiment.yaml names one bag a recording and the topics: /joint_states (sensor_msgs/msg/JointState) and
/joint_group_controller/commands (trajectory_msgs/msg/JointTrajectory, one point a message). Nothing but Python's own
modules is needed, ROS neither.
"""
import argparse
import csv
import math
import pathlib
import re
import shutil
import sqlite3
import struct

EPOCH = 1_700_000_000_000_000_000  # [ns] of the first sample
LATENCY = 200_000                  # [ns] from a stamp until the recorder has the message


class Cdr:
    """Plain CDR, little endian: numbers aligned to their size, counted from behind the header."""

    def __init__(self):
        self.bytes = bytearray(b"\x00\x01\x00\x00")

    def number(self, code, value):
        size = struct.calcsize(code)
        self.bytes += b"\x00" * (-(len(self.bytes) - 4) % size) + struct.pack("<" + code, value)

    def text(self, value):
        raw = value.encode() + b"\x00"
        self.number("I", len(raw))
        self.bytes += raw

    def texts(self, values):
        self.number("I", len(values))
        for value in values:
            self.text(value)

    def doubles(self, values):
        self.number("I", len(values))
        for value in values:
            self.number("d", value)

    def header(self, stamp):
        self.number("i", stamp // 10**9)
        self.number("I", stamp % 10**9)
        self.text("")


def make_joint_state(stamp, joints, columns, row):
    cdr = Cdr()
    cdr.header(stamp)
    cdr.texts(joints)
    for quantity in ("position", "velocity", "effort"):
        names = [f"/joint_states/{joint}/{quantity}" for joint in joints]
        cdr.doubles([row[columns[name]] for name in names] if all(name in columns for name in names) else [])
    return bytes(cdr.bytes)


def make_command(stamp, joints, columns, row):
    cdr = Cdr()
    cdr.header(stamp)
    cdr.texts(joints)
    cdr.number("I", 1)
    for quantity in ("position", "velocity"):
        names = [f"/joint_commands/{joint}/{quantity}" for joint in joints]
        cdr.doubles([row[columns[name]] for name in names] if all(name in columns for name in names) else [])
    cdr.doubles([])  # accelerations
    cdr.doubles([])  # efforts
    cdr.number("i", 0)
    cdr.number("I", 0)
    return bytes(cdr.bytes)


TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO topics VALUES(1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '');
INSERT INTO topics VALUES(2, '/joint_group_controller/commands', 'trajectory_msgs/msg/JointTrajectory', 'cdr', '');
"""


def write_bag(source, folder):
    with open(source) as file:
        rows = csv.reader(line for line in file if line.strip() and not line.startswith("#"))
        names = [name.strip() for name in next(rows)]
        table = [[float(cell) if cell.strip() else math.nan for cell in row] for row in rows]
    columns = {name: i for i, name in enumerate(names)}
    joints = sorted({name.split("/")[2] for name in names if name.startswith("/joint_states/")})
    commanded = [joint for joint in joints if f"/joint_commands/{joint}/position" in columns]
    folder.mkdir(parents=True)
    database = sqlite3.connect(folder / f"{folder.name}_0.db3")
    database.executescript(TABLES)
    for row in table:
        stamp = EPOCH + round(1e9 * row[columns["time"]])
        messages = [(1, stamp + LATENCY, make_joint_state(stamp, joints, columns, row))]
        if commanded:
            messages.append((2, stamp + LATENCY, make_command(stamp, commanded, columns, row)))
        database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", messages)
    database.commit()
    database.close()
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n"
        f"    - {folder.name}_0.db3\n  compression_format: ''\n  compression_mode: ''\n")
    return bool(commanded)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("experiment", type=pathlib.Path, help="folder with experiment.yaml and CSV recordings")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for bags and experiment.yaml; replaced")
    arguments = parser.parse_args()
    text = (arguments.experiment / "experiment.yaml").read_text()
    if arguments.out.exists():
        shutil.rmtree(arguments.out)
    arguments.out.mkdir(parents=True)
    commanded = False
    for name in re.findall(r"file: *([\w./-]+)\.csv", text):
        commanded = write_bag(arguments.experiment / f"{name}.csv", arguments.out / name) or commanded
        text = text.replace(f"{name}.csv", name)
    robot = re.search(r"^robot: *(\S+)", text, re.MULTILINE).group(1)
    shutil.copy(arguments.experiment / robot, arguments.out / pathlib.Path(robot).name)
    text = text.replace(f"robot: {robot}", f"robot: {pathlib.Path(robot).name}")
    text += "topics:\n  joint_states: /joint_states\n"
    text += "  joint_commands: /joint_group_controller/commands\n" if commanded else ""
    (arguments.out / "experiment.yaml").write_text(text)


if __name__ == "__main__":
    main()
