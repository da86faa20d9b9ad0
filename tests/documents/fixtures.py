# SPDX-License-Identifier: BSD-3-Clause
"""Files that a reader of the documents has, or has made before: a recorded run, one that was cut, an experiment."""
import pathlib
import re
import shutil
import subprocess

LOGS = {"run.mcap", "other.mcap", "a.mcap", "b.mcap", "cut.mcap"}


def quiet(words, folder):
    subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=60)


def make_log(path, folder, source):
    first = folder / "first.mcap"
    if not first.exists():
        scenario = source / "models/scenarios/hrp2p_stand.yaml"
        quiet(["build/bin/hrp-simulate", scenario, "--in-process", "--duration", "0.2", "--quiet", "--no-plot", "--log", first], folder)
    content = first.read_bytes()
    path.write_bytes(content[: len(content) * 2 // 3] if path.name == "cut.mcap" else content)


def make_experiment(folder):
    quiet(["build/bin/hrp-make-cases", "--out", "cases", "--cases", "1", "--duration", "2", "--family", "arm", "--effect", "none"], folder)
    shutil.move(next((folder / "cases/cases").iterdir()), folder / "experiment")


def provide(command, folder, source):
    """Makes what the command reads and removes what it will write."""
    written = re.findall(r"(?:--log|--out|recover \S+) (\S+)", command)
    for word in command.split():
        path = folder / word
        if word in written and path.is_file():
            path.unlink()
        elif word in LOGS and word not in written and not path.exists():
            make_log(path, folder, source)
        elif word.startswith("experiment/") and not (folder / "experiment").exists():
            make_experiment(folder)


def make_folder(parent, source, build):
    """A folder that looks like the top of the tree, so that commands leave nothing in the real one."""
    folder = pathlib.Path(parent)
    for entry in source.iterdir():
        if entry.name not in ("build", "logs", "out", ".git") and not entry.name.endswith(".mcap"):
            (folder / entry.name).symlink_to(entry)
    (folder / "build").symlink_to(build)
    return folder
