# SPDX-License-Identifier: BSD-3-Clause
"""Programs of the project, run by tests: BIN SOURCE are a test's first words."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

BIN, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])


def run(*words):
    """Output of a program that must succeed."""
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout


class LoggedRun(unittest.TestCase):
    """A scenario that was run and logged once for all tests of a class: its `log`, in its `folder`."""

    @classmethod
    def log_run(cls, scenario, duration):
        cls.temporary = tempfile.TemporaryDirectory(prefix="hrp-log-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.log = cls.folder / "run.mcap"
        run(BIN / "hrp-simulate", SOURCE / "models/scenarios" / scenario, "--in-process", "--duration", duration, "--quiet", "--no-plot",
            "--log", cls.log)

    @classmethod
    def cat(cls, topic):
        """All messages of a topic of the log."""
        return [json.loads(line)["message"] for line in run(BIN / "hrp-log", "cat", cls.log, topic, "--json").splitlines()]
