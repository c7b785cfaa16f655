#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads what haptic-track package wrote without its code: `package-check.py FOLDER`.

Checks playlists (RFC 8216), transport streams (ISO/IEC 13818-1) or MP4 fragments (ISO/IEC 14496-12), that each segment
begins with an IDR frame and key fields, and that each field and relief has the time of a frame. Prints one line for each
segment: its first time in ticks of 90 kHz, frames, fields, bytes of the codes of the fields.
"""
import re
import struct
import sys
from pathlib import Path

KEY = bytes.fromhex("060e2b34020b01010f48415054494301")
ORIGIN = 900_000  # ticks, of the first frame in a transport stream


def code_of(klv):
    """Tag and code of a field (32) or relief (33) in a KLV set, whose length has two bytes."""
    assert klv[:16] == KEY and klv[16] == 0x82, klv[:19].hex()
    rest, code = klv[19:], None
    assert len(rest) == struct.unpack(">H", klv[17:19])[0]
    while rest:
        tag, size, at = rest[0], rest[1], 2
        if size & 0x80:
            at += size & 0x7F
            size = int.from_bytes(rest[2:at], "big")
        code = (tag, rest[at : at + size]) if tag in (32, 33) else code
        rest = rest[at + size :]
    return code


def time_of(field):
    return (field[0] >> 1 & 7) << 30 | (field[1] << 8 | field[2]) >> 1 << 15 | (field[3] << 8 | field[4]) >> 1


class TransportStream:
    """The packets of all segments, whose counters go on from one to the next."""

    def __init__(self):
        self.counters = {}
        self.clock = -1

    def units(self, data):
        assert len(data) % 188 == 0
        assert [data[i * 188 + 1] << 8 & 0x1F00 | data[i * 188 + 2] for i in (0, 1)] == [0, 0x1000], "tables first"
        units = {}
        for at in range(0, len(data), 188):
            packet = data[at : at + 188]
            pid = packet[1] << 8 & 0x1F00 | packet[2]
            assert packet[0] == 0x47
            assert self.counters.get(pid, packet[3]) & 15 == packet[3] & 15, f"packet lost on {pid:#x}"
            self.counters[pid] = packet[3] + 1
            payload = packet[4 if not packet[3] & 0x20 else 5 + packet[4] :]
            if packet[3] & 0x20 and packet[4] and packet[5] & 0x10:
                clock = int.from_bytes(packet[6:10], "big") << 1 | packet[10] >> 7
                assert clock > self.clock, "the clock runs backwards"
                self.clock = clock
            if packet[1] & 0x40:
                units.setdefault(pid, []).append(b"")
            units[pid][-1] += payload
        return units

    def read(self, data):
        units = self.units(data)
        table = units[0x1000][0]
        end = table[2] << 8 & 0xF00 | table[3]
        streams, at = {}, 13
        while at < end:
            size = table[at + 3] << 8 & 0xF00 | table[at + 4]
            streams[table[at] << 16 | (table[at + 1] << 8 & 0x1F00 | table[at + 2])] = table[at + 5 : at + 5 + size]
            at += 5 + size
        assert streams[0x060102] == b"\x05\x04KLVA" and 0x1B0100 in streams, streams
        frames, fields = [], []
        for unit in units[0x100]:
            assert unit[:4] == b"\0\0\1\xe0"
            time = time_of(unit[9:14])
            assert unit[7] == 0x80 or time_of(unit[14:19]) < time
            frames.append((time - ORIGIN, re.search(rb"\x00\x00\x01[\x05\x25\x45\x65]", unit) is not None))
        for unit in units.get(0x102, []):
            assert unit[:4] == b"\0\0\1\xfc" and unit[6:9] == b"\x81\x80\x05", unit[:9].hex()
            size = struct.unpack(">H", unit[4:6])[0]
            assert len(unit) == size + 6
            fields.append((time_of(unit[9:14]) - ORIGIN, unit[14:]))
        assert not fields or fields.pop()[1] == b"", "an empty unit ends the track of a segment"
        assert self.clock < ORIGIN + max(time for time, _ in frames)
        assert (0x0F0101 in streams) == (0x101 in units)
        return frames, fields


def boxes(data):
    while data:
        size = struct.unpack(">I", data[:4])[0]
        assert 8 <= size <= len(data)
        yield data[4:8], data[8:size]
        data = data[size:]


class Fragments:
    def __init__(self):
        self.ends = {}
        self.events = 0

    def read(self, data):
        frames, fields, kinds = [], [], []
        for kind, content in boxes(data):
            kinds.append(kind)
            if kind == b"styp":  # a segment of DASH; sound and video share a fragment, so that it is none of CMAF
                assert content == b"msdh\0\0\0\0msdhiso6", content
            if kind == b"emsg":
                version, scale, time, duration, number = struct.unpack(">IIQII", content[:24])
                scheme, value, klv = content[24:].split(b"\0", 2)
                assert (version, scale, duration) == (1 << 24, 90000, 0) and number == self.events
                assert (scheme, value) == (b"urn:misb:KLV:bin:1910.1", b"")
                self.events += 1
                fields.append((time, klv))
            if kind == b"moof":
                for name, track in boxes(content):
                    if name == b"traf":
                        frames += self.frames(dict(boxes(track)))
        assert kinds == [b"styp"] + [b"emsg"] * len(fields) + [b"moof", b"mdat"], kinds
        return frames, fields

    def frames(self, track):
        number = struct.unpack(">I", track[b"tfhd"][4:8])[0]
        time = struct.unpack(">Q", track[b"tfdt"][4:12])[0]
        flags, count = struct.unpack(">II", track[b"trun"][:8])
        assert self.ends.get(number, time) == time, "a gap between two segments"
        width = 16 if flags & 0x800 else 8
        frames = []
        for i in range(count):
            values = track[b"trun"][12 + i * width : 12 + (i + 1) * width]
            duration, _ = struct.unpack(">II", values[:8])
            if number == 1:
                sample, offset = struct.unpack(">Ii", values[8:])
                frames.append((time + offset, sample == 0x02000000))
            time += duration
        self.ends[number] = time
        return frames


def check_rate(playlist):
    text = playlist.read_text()
    lines = text.splitlines()
    assert lines[0] == "#EXTM3U" and lines[-1] == "#EXT-X-ENDLIST" and "#EXT-X-PLAYLIST-TYPE:VOD" in lines
    target = int(re.search(r"#EXT-X-TARGETDURATION:(\d+)", text)[1])
    is_mp4 = "#EXT-X-MAP" in text
    reader = Fragments() if is_mp4 else TransportStream()
    if is_mp4:
        head = dict(boxes((playlist.parent / "head.mp4").read_bytes()))
        assert list(head) == [b"ftyp", b"moov"] and head[b"ftyp"] == b"iso6\0\0\0\0iso6", head[b"ftyp"]
    names = [line for line in lines if not line.startswith("#")]
    lengths = [float(length) for length in re.findall(r"#EXTINF:([\d.]+),", text)]
    assert len(names) == len(lengths) > 0
    start = 0.0
    for name, length in zip(names, lengths):
        assert round(length) <= target
        frames, fields = reader.read((playlist.parent / name).read_bytes())
        times = sorted(time for time, _ in frames)
        assert frames[0][1] and frames[0][0] == times[0], "no IDR frame first"
        assert abs(times[0] - start * 90000) <= 1, (times[0], start)
        codes = [code_of(klv) for _, klv in fields]
        for kind in {tag for tag, _ in codes}:
            assert next(code for tag, code in codes if tag == kind)[0] & 1, "no key field first"
            own = [time for (time, _), (tag, _) in zip(fields, codes) if tag == kind]
            assert own == sorted(set(own))
        assert all(time in set(times) for time, _ in fields), "a field between two frames"
        print(f"{playlist.parent.name}/{name} {times[0]} {len(frames)} {len(fields)} {sum(len(code) for _, code in codes)}")
        start += length


def main():
    folder = Path(sys.argv[1])
    text = (folder / "film.m3u8").read_text()
    assert text.startswith("#EXTM3U\n") and "#EXT-X-INDEPENDENT-SEGMENTS" in text
    rates = re.findall(r'#EXT-X-STREAM-INF:BANDWIDTH=\d+,.*CODECS="avc1\.[^"]+".*RESOLUTION=\d+x\d+.*\n(\S+)\n', text)
    assert rates and len(rates) == text.count("STREAM-INF")
    for rate in rates:
        check_rate(folder / rate)


main()
