# SPDX-License-Identifier: BSD-3-Clause
"""How the commands of the documents are run in a test: one rule a kind of command, the first that fits counts.

A command without a rule fails the test: add a rule here. Where a command takes long or needs a file of the reader's, the
rule shows what is run in its place; nothing is left out.
"""
import dataclasses
import re

RUNS = "runs"        # ends by itself with status 0
BESIDE = "beside"    # the same, while a run goes on
WATCHES = "watches"  # shows something of a run that goes on, and ends with it
SERVES = "serves"    # prints an address, answers there, ends with Ctrl-C
OFFERS = "offers"    # a run that waits for somebody; ends with status 0 when the next command has joined
JOINS = "joins"      # joins the run that was offered; both end with status 0
ENVIRONMENT = "environment"  # holds for the commands after it


@dataclasses.dataclass
class Rule:
    pattern: str          # of the whole command
    how: str
    change: tuple = ()    # pairs (pattern, replacement): what is run instead


SHORT_RUN = ((r" --duration [\d.]+", ""), (r"$", " --duration 0.2"))

RULES = [
    Rule(r"export [A-Z_]+=.*", ENVIRONMENT),
    Rule(r"cd [\w/.-]+", ENVIRONMENT),
    # The whole suite, which this test is a part of.
    Rule(r"scripts/test\.sh", RUNS, change=((r"$", " --help"),)),
    Rule(r"scripts/build\.sh( [\w-]+)*", RUNS),
    Rule(r"scripts/install_deps\.sh.*", RUNS),
    Rule(r"(scripts/simulate\.sh|build/bin/hrp-simulate) .*--without \w+.*", OFFERS, change=SHORT_RUN),
    Rule(r"scripts/simulate\.sh --help", RUNS),
    Rule(r'scripts/simulate\.sh .*--controller "python3 .*', RUNS, change=((r'"python3', '"/usr/bin/python3'),) + SHORT_RUN),
    # The viewer ends with the run where nobody could press Ctrl-C.
    Rule(r"scripts/simulate\.sh.*", RUNS, change=SHORT_RUN),
    Rule(r"scripts/view\.sh.*", SERVES),
    Rule(r"build/bin/hrp-viewer.*", SERVES),
    Rule(r"(scripts/build\.sh my-controller && )?build/bin/my-controller", JOINS),
    Rule(r"build/bin/hrp-(collision-checker|controller|dynamics).*", JOINS),
    Rule(r"example_c/hold_pose .*", JOINS),
    Rule(r"example_c/watch_forces .*", WATCHES),
    # Debian's own interpreter has numpy; another one before it in the path may not.
    Rule(r"python3 python/examples/\w+\.py", RUNS, change=((r"^", "/usr/bin/"),)),
    Rule(r"cmake .*", RUNS),
    Rule(r"build/bin/hrp-topic (list|type .*)", BESIDE),
    Rule(r"build/bin/hrp-topic (echo|hz) .*--count.*", BESIDE),
    Rule(r"build/bin/hrp-topic (echo|hz) .*", WATCHES),
    # The run beside has another controller; ros_commands_test sends the documented messages.
    Rule(r"build/bin/hrp-topic pub .*", BESIDE, change=((r"$", " --print"),)),
    Rule(r"build/bin/hrp-doctor", BESIDE),
    Rule(r"build/bin/hrp-run status --follow", WATCHES),
    Rule(r"build/bin/hrp-run .*", BESIDE),
    Rule(r"build/bin/hrp-log .*", RUNS),
    Rule(r"build/bin/hrp-(diagnose|plot|make-motion|simulate).* --help", RUNS),
    Rule(r"scripts/[\w/]+\.(sh|py) --help", RUNS),
    # One experiment on one DDS in place of 20 on two, ten times varied.
    Rule(r"scripts/experiments\.sh( \[?[\w|]+\]?)?", RUNS, change=((r"\.sh.*", ".sh fig8 --runs 0 --dds cyclone"),)),
    # A minute of robot motions; paper_b_test and identify_foot_test run it.
    Rule(r"scripts/identify_foot\.sh", RUNS, change=((r"$", " --help"),)),
    # Two jobs, as the tests run two at a time, however many cores there are.
    Rule(r"scripts/sweep\.sh .*", RUNS, change=((r"$", " --jobs 2"),)),
    # Minutes of figures without pass or fail; benchmark_table_test checks what is made of them.
    Rule(r"scripts/benchmark\.sh", RUNS, change=((r"$", " --help"),)),
    # A trial of hours; prove_concealed_test makes a small one.
    Rule(r"scripts/prove_concealed\.sh", RUNS, change=((r"$", " --help"),)),
    Rule(r"scripts/diagnosis/make_bag\.py .*", RUNS),
    Rule(r"scripts/diagnose\.sh( .*)?", RUNS, change=((r"EXPERIMENT\.yaml", "experiment/experiment.yaml"), (r"\bDIR\b", "diagnosed"))),
]

# Fences of these languages are no commands.
NO_COMMANDS = {"cpp", "c", "xml", "yaml", "json", "text", "python", "idl", "cmake", "html", "csv", "mermaid"}
COMMANDS = {"", "sh", "bash", "console"}


def find_rule(command):
    for rule in RULES:
        if re.fullmatch(rule.pattern, command):
            return rule
    return None


def change(rule, command):
    for pattern, replacement in rule.change:
        command = re.sub(pattern, replacement, command, count=1)
    return command
