#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""secure_test.py BIN SOURCE: who may read and who may command a secured run, on both vendors.

The commands of docs/tutorials/secure.md are run as they stand there. Programs that may not join are given time to: until one
that may has read, and five seconds."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

BIN, SOURCE = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
LIMIT = 60    # [s] for what has to happen
PATIENCE = 5  # [s] for what must not happen
SCENARIO = str(SOURCE / "models/scenarios/squat.yaml")
VENDORS = ("cyclone", "fast")


class Secure(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = pathlib.Path(tempfile.mkdtemp(prefix="hrp_secure_"))
        cls.ours = cls.make_authority("ours")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top, ignore_errors=True)

    @classmethod
    def make_authority(cls, name, *options):
        subprocess.run([str(SOURCE / "scripts/secure.sh"), str(cls.top / name), *options], check=True, stderr=subprocess.DEVNULL)
        return cls.top / name

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="hrp_secure_run_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(("CYCLONEDDS", "FASTRTPS", "HRP_"))}
        self.environment["XDG_RUNTIME_DIR"] = str(self.folder)
        self.strangers = dict(self.environment, XDG_RUNTIME_DIR=str(self.folder / "strangers"))
        (self.folder / "strangers").mkdir(mode=0o700)

    def call(self, *words):
        """(status, output)"""
        done = subprocess.run([str(BIN / words[0]), *map(str, words[1:])], env=self.environment, capture_output=True, text=True, timeout=LIMIT)
        return done.returncode, done.stdout + done.stderr

    def start_run(self, vendor, identity, *options):
        self.run_process = subprocess.Popen([str(BIN / "hrp-simulate"), SCENARIO, "--realtime", "--duration", "600", "--no-plot", "--quiet", "--force", "--dds", vendor,
                                             "--secure", str(identity), "--log", str(self.folder / "run.mcap"), *options],
                                            env=self.environment, stdout=subprocess.DEVNULL, stderr=(self.folder / "run.txt").open("w"))
        self.addCleanup(self.run_process.wait)
        self.addCleanup(self.run_process.terminate)
        end = time.monotonic() + LIMIT
        while not self.call("hrp-run", "status", "--secure", identity)[1].startswith("running"):
            self.assertLess(time.monotonic(), end, "the run does not begin")
        status, domain = self.call("hrp-run", "domain")
        self.assertEqual(status, 0)
        return domain.strip()

    def expect_sound_end(self):
        self.assertEqual(self.run_process.wait(timeout=LIMIT), 0, (self.folder / "run.txt").read_text())

    def goes_on(self, identity):
        return self.call("hrp-run", "status", "--secure", identity)[1].startswith("running")

    # ---- sound runs ---------------------------------------------------------------------------------------------

    def test_a_secured_run_has_the_states_of_a_run_in_one_process(self):
        here = self.folder / "here.mcap"
        self.assertEqual(self.call("hrp-simulate", SCENARIO, "--in-process", "--duration", "0.5", "--no-plot", "--log", here)[0], 0)
        for vendor in VENDORS:
            log = self.folder / f"{vendor}.mcap"
            status, said = self.call("hrp-simulate", SCENARIO, "--duration", "0.5", "--no-plot", "--quiet", "--dds", vendor, "--secure", self.ours, "--log", log)
            self.assertEqual(status, 0, said)
            status, said = self.call("hrp-log", "compare", log, here)
            self.assertEqual(status, 0, said)

    # ---- outsiders ----------------------------------------------------------------------------------------------

    def begin(self, *words):
        """As a stranger."""
        process = subprocess.Popen([str(BIN / words[0]), *map(str, words[1:])], env=self.strangers, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def expect_shut_out(self, domain, vendor, authority, outsiders):
        """All outsiders at once, who know the domain, and even the token: they neither read nor command."""
        entry = next((self.folder / "openhrp-dds").glob("run_*")).read_text()
        self.strangers["HRP_RUN_TOKEN"] = re.search(r"^token (.*)$", entry, re.M)[1]
        place = ("--domain", domain, "--dds", vendor)
        readers = [(who, self.begin("hrp-topic", "echo", topic, "--json", "--count", "1", *place, *identity))
                   for who, identity in outsiders.items() for topic in ("hrp/robot_state", "hrp/robot_description")]
        stoppers = [(who, self.begin("hrp-run", "stop", *place, *identity)) for who, identity in outsiders.items()]
        # Somebody who may read does, at the same time on the same machine; the others have as long, and then some.
        status, said = self.call("hrp-topic", "echo", "hrp/robot_state", "--json", "--count", "1", "--secure", authority / "look")
        self.assertEqual(status, 0, said)
        time.sleep(PATIENCE)
        for who, reader in readers:
            reader.terminate()
            self.assertNotIn("{", reader.communicate(timeout=LIMIT)[0], who)
        for who, stopper in stoppers:
            said = stopper.communicate(timeout=LIMIT)[0]
            self.assertNotEqual(stopper.returncode, 0, who + said)
        self.assertTrue(self.goes_on(authority), vendor)

    def test_outsiders_those_of_another_authority_and_revoked_ones_neither_read_nor_command(self):
        authority, others = self.make_authority("revoking"), self.make_authority("others")
        self.make_authority("revoking", "--add", "guest", "--may", "command")
        old = self.folder / "old_files"
        shutil.copytree(authority / "guest", old)  # a guest who does not take the new list of revoked ones
        self.make_authority("revoking", "--revoke", "guest")
        for vendor in VENDORS:
            domain = self.start_run(vendor, authority)
            self.expect_shut_out(domain, vendor, authority,
                                 {"no identity": (), "another authority": ("--secure", others), "revoked, with old files": ("--secure", old)})
            self.run_process.terminate()
            self.expect_sound_end()
        status, said = self.call("hrp-simulate", SCENARIO, "--secure", authority / "guest")
        self.assertEqual(status, 2, said)
        self.assertIn("this certificate was revoked", said)

    def test_who_forgets_the_identity_is_told(self):
        self.start_run("cyclone", self.ours)
        status, said = self.call("hrp-run", "stop")
        self.assertEqual(status, 1)
        self.assertIn("is secured: --secure DIR", said)

    # ---- identities that may less -------------------------------------------------------------------------------

    def test_a_look_only_identity_reads_and_cannot_command(self):
        for vendor in VENDORS:
            self.start_run(vendor, self.ours)
            look = self.ours / "look"
            status, said = self.call("hrp-topic", "echo", "hrp/robot_state", "--json", "--count", "1", "--secure", look)
            self.assertEqual(status, 0, said)
            self.assertIn("{", said)
            for request in ("pause", "stop"):
                status, said = self.call("hrp-run", request, "--secure", look)
                self.assertNotEqual(status, 0, said)
                self.assertIn("writer of hrp/run_control", said)
            self.assertTrue(self.goes_on(look), vendor)
            self.assertEqual(self.call("hrp-run", "stop", "--secure", self.ours / "command")[0], 0)
            self.expect_sound_end()

    def test_a_look_only_identity_sends_no_ros_commands(self):
        message = "{joint_names: [R_ELBOW], points: [{positions: [-0.6], time_from_start: {sec: 1}}]}"
        for vendor in VENDORS:
            self.start_run(vendor, self.ours, "--controller", str(BIN / "hrp-controller-ros"))
            status, said = self.call("hrp-topic", "pub", "joint_trajectory", message, "--secure", self.ours / "look")
            self.assertEqual(status, 2, said)
            self.assertIn("writer of rt/joint_trajectory", said)
            status, said = self.call("hrp-topic", "pub", "joint_trajectory", message, "--secure", self.ours / "command")
            self.assertEqual(status, 0, said)
            self.run_process.terminate()
            self.expect_sound_end()

    def test_a_look_only_identity_is_no_controller(self):
        for vendor in VENDORS:
            run = subprocess.Popen([str(BIN / "hrp-simulate"), SCENARIO, "--quiet", "--no-plot", "--dds", vendor, "--secure", str(self.ours),
                                    "--without", "controller", "--log", str(self.folder / f"{vendor}.mcap")],
                                   env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(run.wait)
            self.addCleanup(run.terminate)
            status, said = self.call("hrp-controller", "--secure", self.ours / "look")
            self.assertNotEqual(status, 0, said)
            self.assertIn("cannot make writer", said)
            run.terminate()
            run.wait()

    # ---- identities that count no more --------------------------------------------------------------------------

    def test_an_identity_that_is_over_is_refused_at_start(self):
        over = self.make_authority("over", "--days", "0")
        status, said = self.call("hrp-simulate", SCENARIO, "--secure", over)
        self.assertEqual(status, 2, said)
        self.assertIn("this certificate is over", said)

    # ---- refused at start ---------------------------------------------------------------------------------------

    def expect_refused(self, words, *options):
        status, said = self.call("hrp-simulate", SCENARIO, *options)
        self.assertEqual(status, 2, said)
        self.assertIn(words, said)

    def test_what_cannot_work_is_refused_at_start(self):
        self.expect_refused("a secured run has one DDS", "--secure", self.ours, "--dds-for", "controller=fast")
        self.expect_refused("excludes --secure", "--secure", self.ours, "--in-process")
        self.expect_refused("has no cert.pem", "--secure", self.folder)
        open_key = self.folder / "open_key"
        shutil.copytree(self.ours / "command", open_key)
        (open_key / "key.pem").chmod(0o644)
        self.expect_refused("other users may read this key", "--secure", open_key)
        shutil.copy(self.ours / "look/key.pem", open_key / "key.pem")
        self.expect_refused("is not the key of the certificate", "--secure", open_key)

    def test_a_joiner_of_the_other_vendor_is_refused_with_the_reason(self):
        self.start_run("cyclone", self.ours)
        status, said = self.call("hrp-run", "pause", "--secure", self.ours, "--dds", "fast")
        self.assertEqual(status, 1)
        self.assertIn("a secured run has one DDS", said)

    # ---- the page -----------------------------------------------------------------------------------------------

    def test_the_commands_of_the_tutorial(self):
        text = (SOURCE / "docs/tutorials/secure.md").read_text()
        commands = re.findall(r"^(?:run|desk)\$ (.*?)(?:\s+#.*)?$", text, re.M)
        self.assertGreaterEqual(len(commands), 6)
        environment = dict(self.environment, HRP_BUILD_DIR=str(BIN.parent))
        for each in ("models", "scripts", "build"):
            (self.folder / each).symlink_to(BIN.parent if each == "build" else SOURCE / each)
        running = None
        for command in commands:
            words = shlex.split(command)
            if words[0] == "build/bin/hrp-simulate":
                running = subprocess.Popen([*words, "--log", str(self.folder / "page.mcap")], cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                self.addCleanup(running.wait)
                self.addCleanup(running.terminate)
                end = time.monotonic() + LIMIT
                while not self.call("hrp-run", "status", "--secure", self.folder / "secure")[1].startswith("running"):
                    self.assertLess(time.monotonic(), end, "the run does not begin")
                continue
            if words[0] == "build/bin/hrp-viewer":
                viewer = subprocess.Popen(words, cwd=self.folder, env=environment, stdout=subprocess.PIPE, text=True)
                self.addCleanup(viewer.stdout.close)
                self.addCleanup(viewer.wait)
                self.addCleanup(viewer.terminate)
                self.assertIn("http://", viewer.stdout.readline())
                continue
            done = subprocess.run(words, cwd=self.folder, env=environment, capture_output=True, text=True, timeout=LIMIT)
            self.assertEqual(done.returncode, 0, command + "\n" + done.stdout + done.stderr)
        self.assertEqual(running.wait(timeout=LIMIT), 0, "the last command stops the run")


if __name__ == "__main__":
    if not shutil.which("openssl"):
        print("SKIPPED: openssl is missing")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
