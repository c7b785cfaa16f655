#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Many viewers of a packaged film: `crowd.py ADDRESS PLAYLIST VIEWERS SECONDS`.

Each viewer has a connection of its own and does what a player does: it reads the playlists, begins to play when the
first segment is there, and asks for the next one as soon as less than 8 s are left. A segment is late if it is not
there when it is to be played. At its end the film begins anew. Prints what happened; the exit status is 1 if an answer
was wrong.
"""
import asyncio
import re
import resource
import socket
import sys
import time

AHEAD = 8.0  # s
SPREAD = 4.0  # s, in which all have come
scrap = bytearray(1 << 20)


class Viewer:
    def __init__(self, host, port):
        self.host, self.port = host, port
        self.segments = self.late = self.bytes = 0
        self.least = AHEAD  # s that were left when a segment came

    async def get(self, path, keep=False):
        loop = asyncio.get_running_loop()
        await loop.sock_sendall(self.socket, f"GET {path} HTTP/1.1\r\nHost: {self.host}\r\n\r\n".encode())
        head = b""
        while b"\r\n\r\n" not in head:
            more = await loop.sock_recv(self.socket, 4096)
            if not more:
                raise RuntimeError("the connection was closed")
            head += more
        head, body = head.split(b"\r\n\r\n", 1)
        if not head.startswith(b"HTTP/1.1 200 "):
            raise RuntimeError(head.split(b"\r\n")[0].decode())
        left = int(re.search(rb"(?i)\r\ncontent-length: (\d+)", head)[1]) - len(body)
        while left > 0:
            if keep:
                more = await loop.sock_recv(self.socket, left)
                body += more
                size = len(more)
            else:
                size = await loop.sock_recv_into(self.socket, memoryview(scrap)[: min(left, len(scrap))])
            if size == 0:
                raise RuntimeError("an answer ends early")
            left -= size
            self.bytes += size
        return body.decode() if keep else ""

    async def watch(self, playlist, seconds):
        self.socket = socket.create_connection((self.host, self.port))
        self.socket.setblocking(False)
        with self.socket:
            folder = playlist.rpartition("/")[0]
            rate = [line for line in (await self.get(playlist, True)).splitlines() if line and line[0] != "#"][0]
            text = await self.get(f"{folder}/{rate}", True)
            lengths = [float(length) for length in re.findall(r"#EXTINF:([\d.]+)", text)]
            names = [line for line in text.splitlines() if line and line[0] != "#"]
            folder = f"{folder}/{rate.rpartition('/')[0]}"
            end = due = None
            while due is None or due < end:
                for name, length in zip(names, lengths):
                    await self.get(f"{folder}/{name}")
                    now = time.monotonic()
                    if due is None:
                        due, end = now, now + seconds
                    else:
                        self.late += now > due
                        self.least = min(self.least, due - now)
                    self.segments += 1
                    due += length
                    await asyncio.sleep(max(0, due - time.monotonic() - AHEAD))
                    if due >= end:
                        break


async def main():
    address, playlist, count, seconds = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
    host, port = address.split(":")
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    viewers = [Viewer(host, int(port)) for _ in range(count)]

    async def begin(number, viewer):
        await asyncio.sleep(SPREAD * number / count)
        await viewer.watch(playlist, seconds)

    started = time.monotonic()
    ends = await asyncio.gather(*(begin(i, v) for i, v in enumerate(viewers)), return_exceptions=True)
    failures = [str(end) for end in ends if end is not None]
    megabits = 8e-6 * sum(v.bytes for v in viewers) / (time.monotonic() - started)
    print(
        f"{count} viewers, {sum(v.segments for v in viewers)} segments, {sum(v.late for v in viewers)} late, "
        f"at least {min(v.least for v in viewers):.1f} s left, {megabits:.0f} Mbit/s, {len(failures)} failures"
    )
    for failure in sorted(set(failures)):
        print(failure)
    sys.exit(1 if failures else 0)


asyncio.run(main())
