# SPDX-License-Identifier: BSD-3-Clause
"""Programs of the project, run by tests."""
import subprocess


def run(*words):
    """Output of a program that must succeed."""
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout
