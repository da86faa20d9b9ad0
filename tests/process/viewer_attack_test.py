#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""viewer_attack_test.py BIN SOURCE: clients that hang up in mid-sentence, that never ask, that ask a byte at a time: the
viewer goes on and answers others. And a viewer that dies is missed in words by the run that started it."""
import base64
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

BIN, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
del sys.argv[1:3]
PATIENCE = 60  # [s] only for what never comes
ATTACKS = 200  # the viewer of before died of 2 to 92 of them


def make_frame(text):
    """A masked text frame; the mask is zero."""
    payload = text.encode()
    head = bytes([0x81, 0x80 | len(payload)]) if len(payload) < 126 else bytes([0x81, 0xfe]) + struct.pack('>H', len(payload))
    return head + bytes(4) + payload


class Viewer:
    def __init__(self, folder, *words):
        self.output = open(os.path.join(folder, 'viewer.txt'), 'w+b')
        self.process = subprocess.Popen([BIN / 'hrp-viewer', *words], stdout=self.output, stderr=self.output, stdin=subprocess.DEVNULL)
        end = time.monotonic() + PATIENCE
        address = None
        while address is None and time.monotonic() < end and self.process.poll() is None:
            time.sleep(0.02)
            address = re.search(r'http://\S+', self.text())
        if address is None:
            raise AssertionError('the viewer prints no address: ' + self.text())
        self.address = address.group(0)
        self.port = int(re.search(r':(\d+)/', self.address)[1])
        self.query = self.address.split('?')[1]

    def text(self):
        return pathlib.Path(self.output.name).read_text(errors='replace')

    def connect(self):
        return socket.create_connection(('127.0.0.1', self.port), timeout=PATIENCE)

    def open_socket(self, protocol=''):
        """A WebSocket after its handshake."""
        client = self.connect()
        more = 'Sec-WebSocket-Protocol: %s\r\n' % protocol if protocol else ''
        key = base64.b64encode(os.urandom(16)).decode()
        client.sendall(('GET /ws?%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n'
                        'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n%s\r\n' % (self.query, self.port, key, more)).encode())
        answer = b''
        while b'\r\n\r\n' not in answer:
            part = client.recv(4096)
            if not part:
                raise AssertionError('no upgrade: %r' % answer)
            answer += part
        if b' 101 ' not in answer:
            raise AssertionError('no upgrade: %r' % answer)
        return client

    def ask(self):
        with urllib.request.urlopen(self.address, timeout=PATIENCE) as page:
            return page.status

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        status = self.process.wait(PATIENCE)
        self.output.close()
        return status


def wait_for_run(process_id):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if str(process_id) in subprocess.run([BIN / 'hrp-run', 'list'], capture_output=True, text=True).stdout:
            return
        time.sleep(0.05)
    raise AssertionError('no run')


def hang_up(client, frames):
    """All at once in one packet, then an end without a goodbye (RST)."""
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
    client.sendall(b''.join(frames))
    client.close()


class Attacks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        log = os.path.join(cls.folder.name, 'run.mcap')
        subprocess.run([BIN / 'hrp-simulate', SOURCE / 'models/scenarios/hrp2p_stand.yaml', '--in-process', '--duration', '0.2',
                        '--quiet', '--no-plot', '--log', log], check=True, stdout=subprocess.DEVNULL, timeout=PATIENCE)
        cls.log = log

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        self.viewer = Viewer(self.folder.name, self.log)

    def tearDown(self):
        self.assertEqual(self.viewer.end(), 0, self.viewer)

    def check_alive(self):
        self.assertIsNone(self.viewer.process.poll(), self.viewer.text())
        self.assertEqual(self.viewer.ask(), 200)

    def test_clients_that_hang_up_in_mid_sentence_end_alone(self):
        self.viewer.end()
        run = subprocess.Popen([BIN / 'hrp-simulate', SOURCE / 'models/scenarios/hrp2p_stand.yaml', '--duration', '0', '--realtime',
                                '--quiet', '--no-plot', '--log', os.path.join(self.folder.name, 'live.mcap')], stdout=subprocess.DEVNULL)
        try:
            wait_for_run(run.pid)
            self.viewer = Viewer(self.folder.name, '--run', str(run.pid))
            # An answer is on its way, and others are due, when the client goes.
            openings = [[], [make_frame('{"op":"open","source":0}')]]
            subscribe = make_frame('{"op":"subscribe","signals":["hrp/robot_state:X_WB.translation.z"]}')
            peek = make_frame('{"op":"peek","topic":"hrp/contact_forces"}')
            for attack in range(ATTACKS):
                hang_up(self.viewer.open_socket(), openings[attack % 2] + 20 * [(subscribe, peek)[attack // 2 % 2]])
            self.check_alive()
        finally:
            run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(PATIENCE), 0)

    def test_foxglove_clients_that_hang_up_end_alone(self):
        for _ in range(ATTACKS // 4):
            hang_up(self.viewer.open_socket('foxglove.sdk.v1'), 20 * [make_frame('{"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]}')])
        self.check_alive()

    def test_nonsense_and_a_hang_up_end_alone(self):
        for attack in range(ATTACKS // 4):
            nonsense = make_frame('{"op":"nothing"}') if attack % 2 else b'\xff\x8a' + os.urandom(14)
            hang_up(self.viewer.open_socket(), [make_frame('{"op":"open","source":0}'), nonsense] * 10)
        self.check_alive()

    def test_connections_that_ask_nothing_keep_nobody_out(self):
        idle = [self.viewer.connect() for _ in range(100)]  # the viewer has room for 64
        self.check_alive()
        page = self.viewer.open_socket()
        idle += [self.viewer.connect() for _ in range(100)]
        self.check_alive()
        page.sendall(make_frame('{"op":"open","source":0}'))
        self.assertTrue(page.recv(16), 'a page that is there is not pushed out')
        for each in idle + [page]:
            each.close()

    def test_questions_that_never_end_keep_nobody_out(self):
        slow = []
        for _ in range(100):
            client = self.viewer.connect()
            client.sendall(b'GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ')
            slow.append(client)
        self.check_alive()
        for each in slow:
            each.close()

    def test_without_the_token_nothing_is_told(self):
        for path in ('/', '/ws', '/?token=', '/?token=' + '0' * 32):
            with self.assertRaises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen('http://127.0.0.1:%d%s' % (self.viewer.port, path), timeout=PATIENCE)
            self.assertEqual(refused.exception.code, 403)
            refused.exception.close()


class Launcher(unittest.TestCase):
    def test_a_viewer_that_dies_is_said_and_the_run_goes_on(self):
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, 'run.mcap')
            run = subprocess.Popen([BIN / 'hrp-simulate', SOURCE / 'models/scenarios/hrp2p_stand.yaml', '--view', '--duration', '2',
                                    '--speed', '1', '--quiet', '--no-plot', '--log', log],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
            try:
                viewer = None
                while viewer is None and run.poll() is None:
                    listed = subprocess.run(['ps', '--ppid', str(run.pid), '-o', 'pid=,args='], capture_output=True, text=True).stdout
                    viewer = re.search(r'(\d+) \S*/hrp-viewer ', listed)
                os.kill(int(viewer[1]), signal.SIGKILL)
                output, _ = run.communicate(timeout=PATIENCE)
            finally:
                run.kill()
            self.assertEqual(run.returncode, 0, output)
            self.assertIn('the viewer (hrp-viewer, process %s) was killed by signal 9 (SIGKILL); the run goes on' % viewer[1], output)
            self.assertIn('complete up to step 2000', output)


if __name__ == '__main__':
    unittest.main()
