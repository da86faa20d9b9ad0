# SPDX-License-Identifier: BSD-3-Clause
"""A folder of a test's own, and an environment without settings of ROS or DDS of whoever runs it."""
import os
import pathlib
import shutil
import tempfile
import unittest

SETTINGS = ("ROS_", "CYCLONEDDS", "FASTRTPS", "HRP_")


class OwnSurroundings(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="hrp_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(SETTINGS)}
        self.environment["XDG_RUNTIME_DIR"] = str(self.folder)
