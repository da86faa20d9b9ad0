# SPDX-License-Identifier: BSD-3-Clause
"""The diagnosis and the identification of soles: runs the programs and reads their reports."""
from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import sys
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional


class ProgramError(RuntimeError):
    """A program that ended with an error; the message is what it said."""


def find_program(name: str) -> str:
    """A program of this installation: beside the build folder's or the prefix's Python package, else in PATH."""
    package = pathlib.Path(__file__).resolve().parent
    for up in (package.parents[1], package.parents[3] if len(package.parents) > 3 else package):
        program = up / "bin" / name
        if os.access(program, os.X_OK) and program.is_file():
            return str(program)
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError(f"{name} is neither in the bin folder beside {package} nor in PATH; scripts/build.sh builds it")
    return found


def _print_progress(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _run(words: List[str], on_progress: Optional[Callable[[str], None]]) -> None:
    """Runs a program; every line that it writes goes to on_progress. Raises ProgramError."""
    lines: List[str] = []
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace") as process:
        assert process.stdout is not None
        try:
            for line in process.stdout:
                lines.append(line.rstrip())
                if on_progress is not None:
                    on_progress(lines[-1])
        except BaseException:
            process.terminate()
            raise
    if process.returncode != 0:
        raise ProgramError(f"{pathlib.Path(words[0]).name} ended with status {process.returncode}:\n" + "\n".join(lines[-20:]))


@dataclass
class Finding:
    """One effect that the model lacks (docs/report.md)."""

    effect: str
    where: Dict[str, str]
    """{"joint": ...}, {"link": ...} or {"sensor": ...}."""
    grade: str
    """certain, supported or ambiguous."""
    family: str
    probability: Optional[float]
    parameters: Dict[str, Dict[str, Any]]
    """Name -> {"value", "std", "ci95", "unit"}."""
    statement: str
    raw: Dict[str, Any]
    """All fields of the report."""

    def value(self, parameter: Optional[str] = None) -> float:
        """Of a parameter, or of the only one."""
        name = next(iter(self.parameters)) if parameter is None and len(self.parameters) == 1 else parameter
        if name not in self.parameters:
            raise ValueError(f"parameter must be one of {', '.join(self.parameters)}, not {parameter!r}")
        return float(self.parameters[name]["value"])


class DiagnosisReport:
    """What the diagnosis wrote into a folder."""

    def __init__(self, folder: str) -> None:
        self.folder = pathlib.Path(folder)
        path = self.folder / "report.json"
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no report of a diagnosis")
        self.raw: Dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        """All of report.json (docs/report.md)."""

    @property
    def verdict(self) -> str:
        """no_mismatch, explained, mostly_explained, partly_explained, unexplained or not_judged."""
        return str(self.raw["verdict"])

    @property
    def summary(self) -> str:
        """The first sentences of the report."""
        return str(self.raw.get("summary", ""))

    @property
    def findings(self) -> List[Finding]:
        """In the order of the report."""
        return [Finding(f["effect"], f["where"], f["grade"], f.get("family", ""), f.get("probability"), f["parameters"],
                        f.get("statement", ""), f) for f in self.raw["findings"]]

    @property
    def page(self) -> str:
        """The report for people."""
        return str(self.folder / "report.html")

    @property
    def updated_scenario(self) -> str:
        """The model with what was found: Simulation(report.updated_scenario) runs it."""
        return str(self.folder / "updated" / "scenario.yaml")

    @property
    def series(self) -> Dict[str, Any]:
        """The curves behind the page's plots (docs/diagnosis_series.md)."""
        loaded: Dict[str, Any] = json.loads((self.folder / "series.json").read_text(encoding="utf-8"))
        return loaded


def diagnose(experiment: str, out: str, jobs: Optional[int] = None, patience: Optional[float] = None,
             on_progress: Optional[Callable[[str], None]] = _print_progress) -> DiagnosisReport:
    """Finds what a simulation left out: hrp-diagnose on an experiment.yaml, into the folder `out`.

    jobs: threads; the report does not depend on it. patience: times the usual work of a search. on_progress gets each
    line of progress (default: printed to stderr; None: quiet). Raises ProgramError with what the program said.
    """
    words = [find_program("hrp-diagnose"), str(experiment), "--out", str(out)]
    if jobs is not None:
        words += ["--jobs", str(jobs)]
    if patience is not None:
        words += ["--patience", str(patience)]
    _run(words, on_progress)
    return DiagnosisReport(str(out))


class FootReport:
    """What the identification of the soles wrote into a folder."""

    def __init__(self, folder: str) -> None:
        self.folder = pathlib.Path(folder)
        if not self.page_path.is_file():
            raise FileNotFoundError(f"{self.page_path}: no report of an identification")

    @property
    def page_path(self) -> pathlib.Path:
        """The report for people."""
        return self.folder / "report.html"

    @property
    def identified_scenario(self) -> str:
        """The scenario with the soles that were found."""
        return str(self.folder / "identified.yaml")

    @property
    def foot_bush(self) -> Dict[str, Dict[str, Any]]:
        """By foot: stiffness and damping, kz [N/m], k_roll, k_pitch [N m/rad], ... Needs the package python3-yaml."""
        import yaml
        with open(self.identified_scenario, encoding="utf-8") as file:
            found: Dict[str, Dict[str, Any]] = yaml.safe_load(file).get("foot_bush", {})
        return found


def identify_foot(source: str, out: str, on_progress: Optional[Callable[[str], None]] = _print_progress) -> FootReport:
    """Stiffness and damping of the soles: from an experiment with `recordings`, or from a scenario, whose robot then makes
    the motions in process (a minute). Raises ProgramError."""
    program = find_program("hrp-identify-foot")
    text = pathlib.Path(source).read_text(encoding="utf-8")
    pathlib.Path(out).mkdir(parents=True, exist_ok=True)
    if any(line.startswith("recordings:") for line in text.splitlines()):
        _run([program, "experiment", str(source), "--out", str(out)], on_progress)
        return FootReport(str(out))
    runs = str(pathlib.Path(out) / "runs")
    try:
        _run([program, "make", str(source), runs], on_progress)
    except ProgramError as error:
        if "status 1:" not in str(error):  # 1: some motion was refused, the others are used
            raise
    _run([program, "fit", str(pathlib.Path(runs) / "robot.yaml"), runs, "--out", str(out), "--in-process"], on_progress)
    return FootReport(str(out))
