#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The sockets of spidar-emulator: what a client does to its connection is no harm to the others.

Usage: emulator-test.py SPIDAR-EMULATOR
"""

import re
import select
import socket
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EMULATOR = sys.argv.pop(1)
LATCH = bytes([0x51]) + bytes(31)  # USB2.0 Simple: the unit then has one reply of 32 bytes
CONTROL, OUT, IN = 0, 2, 6  # endpoints


class Emulator:
    """Two units on a free port."""

    def __init__(self, folder, *commands):
        self.control = str(Path(folder) / "control")
        options = [f"--do={command}" for command in commands]
        self.process = subprocess.Popen(
            [EMULATOR, "--port=0", f"--control={self.control}", "--controller=simple", "--controller=simple",
             *options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port = int(re.search(r"port (\d+)", self.process.stdout.readline()).group(1))
        self.bus_ids = [self.process.stdout.readline().split()[0] for _ in range(2)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.communicate()

    def commands(self):
        client = socket.socket(socket.AF_UNIX)
        client.connect(self.control)
        return client

    def attached(self, unit):
        client = socket.create_connection(("127.0.0.1", self.port))
        client.sendall(struct.pack(">HHI32s", 0x0111, 0x8003, 0, self.bus_ids[unit].encode()))
        assert len(client.recv(320, socket.MSG_WAITALL)) == 320
        submit(client, 0, CONTROL, setup=bytes([0, 9, 1, 0, 0, 0, 0, 0]))  # SET_CONFIGURATION 1
        expect_done(client)
        return client


def submit(client, sequence, endpoint, data=b"", setup=bytes(8)):
    is_in = endpoint == IN
    length = 32 if is_in else len(data)
    client.sendall(struct.pack(">10I8s", 1, sequence, 1, is_in, endpoint, 0, length, 0, 0, 0, setup) + data)


def expect_done(client):
    status = struct.unpack(">12I", client.recv(48, socket.MSG_WAITALL))[5]
    assert status == 0, status


def ask_for_counts(client):
    """Returns when the request was taken: its answer is late."""
    submit(client, 1, OUT, LATCH)
    expect_done(client)
    submit(client, 2, IN)


class Sockets(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def test_a_client_may_leave_before_its_commands_are_answered(self):
        with Emulator(self.folder.name) as emulator:
            for _ in range(20):
                with emulator.commands() as client:
                    client.sendall(b"thaw\nthaw\nthaw\n")
            with emulator.commands() as client:
                client.sendall(b"thaw\n")
                self.assertEqual(client.recv(3), b"ok\n")
            self.assertIsNone(emulator.process.poll())

    def test_a_reply_that_is_due_later_does_not_hold_back_one_that_is_due_before(self):
        with Emulator(self.folder.name, "late 300 @1", "late 6000 @2") as emulator:
            with emulator.attached(1) as later, emulator.attached(0) as sooner:
                ask_for_counts(sooner)
                ask_for_counts(later)
                ready, _, _ = select.select([sooner, later], [], [])
                self.assertEqual(ready, [sooner])

    def test_a_log_that_is_a_fifo_is_refused(self):
        fifo = str(Path(self.folder.name) / "fifo")
        subprocess.run(["mkfifo", fifo], check=True)
        told = subprocess.run([EMULATOR, "--port=0", f"--log={fifo}"], stdin=subprocess.DEVNULL,
                              capture_output=True, text=True)
        self.assertNotEqual(told.returncode, 0)
        self.assertIn("it is a FIFO", told.stderr)


if __name__ == "__main__":
    unittest.main()
