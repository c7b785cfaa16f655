#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Holds the quoted includes of the source against the table of rooms in docs/architecture.md.

Usage: includes.py [ROOT]

A row of the table names a folder, other folders whose headers it includes, the arrows between its rooms, and which of
its rooms and files include GStreamer, GLib or OpenCV. A room is a folder in that folder. These rules hold:

* A room includes only rooms from which arrows lead to it. Each arrow and each name of the table is needed.
* What lies beside the rooms (the ground) includes none of them.
* An include names its file by the path from the folder of the table, so that a line shows its arrow.
* A room is entered only by the headers that its README names after `* Doors:`. Tests may open every door.
* docs/images/house.dot has the same arrows within each folder, between nodes named FOLDER/ROOM.
* A header declares the functions that its own room defines.
* What starts a plugin or a program lies in a room that no other includes.
* No folder holds more than MOST_FILES files.

Compilers do not say this: `-MM` lists what is reached, but not who reaches it, and only what this machine builds.
"""

import re
import sys
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

MOST_FILES = 24  # what a reader sees at a glance
PAGE = "docs/architecture.md"
PICTURE = "docs/images/house.dot"
FOLDER, INCLUDES, ROOMS, LIBRARIES = "folder", "includes also", "rooms", "GStreamer, GLib or OpenCV in"
SCANNED = ("gst-plugins", "spidar", "pipelines")
SOURCES = (".cpp", ".hpp", ".c", ".h", ".js")
STARTS = ("plugin.cpp", "haptic-track.cpp", "feeling-wind.cpp")
QUOTED = re.compile(r'^#\s*(?:include|define\s+HWY_TARGET_INCLUDE)\s+(?:"|<(?=spidar/))([^">]+)', re.MULTILINE)
IMPORTED = re.compile(r"""(?:^import\b[^;]*?|^export\b[^;]*?\bfrom |\bimport\()'(\.[^']+)'""", re.MULTILINE)
HEAVY = re.compile(r"^#include <((?:gst|gio|opencv2|gtk)/|glib)", re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
FUNCTION = re.compile(r"^(?!using|return|typedef|static_assert)[A-Za-z_](?:[\w:<>,&*\[\] ]|\n(?! ))*?[ &*\n](\w+)\(", re.MULTILINE)


def read(path):
    return path.read_text(encoding="utf-8")


@dataclass
class Row:
    """One folder of the table."""

    folder: Path
    uses: list  # folders
    arrows: list  # (source, room): the room includes the source
    rooms: set
    heavy: set  # rooms and files; '' is the whole folder

    def reachable(self, room):
        """The rooms from which arrows lead to this one."""
        found, waiting = set(), [room]
        while waiting:
            target = waiting.pop()
            new = {source for source, to in self.arrows if to == target} - found
            found |= new
            waiting += new
        return found


def quoted(cell):
    return re.findall(r"`([^`]+)`", cell)


def read_table(page):
    """The rows of the table whose head begins with `folder`. A chain is a line of a cell, with an arrow between names."""
    rows, head = {}, []
    for line in read(page).splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            head = []
        elif cells[0] == FOLDER:
            head = cells
        elif head and not cells[0].startswith("---"):
            cell = dict(zip(head, cells))
            chains = [quoted(chain) for chain in cell[ROOMS].split("<br>")]
            folder = Path(quoted(cell[FOLDER])[0])
            rows[folder] = Row(
                folder=folder,
                uses=[Path(name) for name in quoted(cell[INCLUDES])],
                arrows=[arrow for chain in chains for arrow in zip(chain, chain[1:])],
                rooms={room for chain in chains for room in chain},
                heavy=set(quoted(cell[LIBRARIES])) or ({""} if cell[LIBRARIES] == "all" else set()),
            )
    return rows


class House:
    def __init__(self, root, most_files=MOST_FILES):
        self.root = Path(root)
        self.rows = read_table(self.root / PAGE)
        self.problems = []
        self.files = {}  # path -> (row, room); the ground is the room ''
        self.texts = {}
        self.includes = defaultdict(set)
        self.place_files()
        self.check_size(most_files)
        for path in self.files:
            self.resolve_includes(path)
        self.check_arrows()
        self.check_picture()
        self.check_doors()
        self.check_heavy()
        self.check_declarations()

    def complain(self, text):
        self.problems.append(text)

    # ---- where files are

    def folders(self):
        for top in SCANNED:
            yield from (path for path in [self.root / top, *(self.root / top).rglob("*")] if path.is_dir())

    def place_files(self):
        for folder in self.folders():
            for path in sorted(folder.iterdir()):
                if path.suffix in SOURCES or path.name.endswith(".hpp.in"):
                    self.place_file(path.relative_to(self.root))

    def place_file(self, path):
        row = next((self.rows[parent] for parent in path.parents if parent in self.rows), None)
        if row is None:
            self.complain(f"{path} lies in no folder of the table")
            return
        inside = path.relative_to(row.folder).parts
        room = inside[0] if row.rooms and len(inside) > 1 else ""
        if room and (room not in row.rooms or len(inside) > 2):
            self.complain(f"{path} lies in no room of {row.folder}")
            return
        self.files[path] = row, room
        self.texts[path] = read(self.root / path)
        if path.name in STARTS and row.rooms and (not room or any(source == room for source, _ in row.arrows)):
            self.complain(f"{path} starts a program, but does not lie in the last room")

    def check_size(self, most_files):
        for folder in self.folders():
            count = sum(path.is_file() for path in folder.iterdir())
            if count > most_files:
                self.complain(f"{folder.relative_to(self.root)} holds {count} files, more than {most_files}")

    def name_of(self, path):
        row, room = self.files[path]
        return f"{row.folder}/{room}".rstrip("/")

    # ---- who includes whom

    def resolve_includes(self, path):
        if path.suffix == ".js":
            names = IMPORTED.findall(self.texts[path])
        else:
            names = QUOTED.findall(self.texts[path])
        for name in names:
            found = self.find(path, name)
            if len(found) == 1:
                self.includes[path].add(found[0])
            elif found or not self.is_generated(path, name):
                self.complain(f'{path} includes "{name}", which fits {len(found) or "none"} of the files it may include')

    def find(self, path, name):
        """The files that a name fits: those beside the file before those of its folder, and these before others."""
        row, _ = self.files[path]
        beside = (self.root / path.parent / name).resolve()
        if beside.is_relative_to(self.root.resolve()):
            target = beside.relative_to(self.root.resolve())
            if target in self.files:
                self.check_spelling(path, name, target)
                return [target]
        if path.suffix == ".js":
            return []
        own = list(self.fitting(row.folder, name))
        return own or [target for folder in row.uses for target in self.fitting(folder, name)]

    def fitting(self, folder, name):
        for target, (row, _) in self.files.items():
            if row.folder != folder:
                continue
            inside = target.relative_to(folder)
            names = {str(inside)}
            if inside.suffix == ".in":  # the build puts what it makes of NAME.in beside the rooms
                names.add(inside.stem)
            if not row.rooms:  # nor has what lies deeper a room to name
                names.add(inside.name)
            if name in names:
                yield target

    def check_spelling(self, path, name, target):
        row, room = self.files[target]
        if room and path.suffix != ".js" and target.relative_to(row.folder) != Path(name):
            self.complain(f'{path} includes "{name}", but should name its room: "{target.relative_to(row.folder)}"')

    def is_generated(self, path, name):
        return any(
            f"'{Path(name).name}'" in read(self.root / folder / "meson.build")
            for folder in path.parents
            if (self.root / folder / "meson.build").is_file()
        )

    # ---- rules

    def check_arrows(self):
        used_arrows, used_folders = set(), set()
        for path, targets in self.includes.items():
            row, room = self.files[path]
            for target in targets:
                home, door = self.files[target]
                if home is not row:
                    used_folders.add((row.folder, home.folder))
                elif door and door != room:
                    used_arrows.add((row.folder, door, room))
                    if not room:
                        self.complain(f"{path} lies on the ground and includes {target} of a room")
                    elif door not in row.reachable(room):
                        self.complain(f"{path} includes {target}: no arrow leads from {door} to {room}")
        for row in self.rows.values():
            for source, room in row.arrows:
                if (row.folder, source, room) not in used_arrows:
                    self.complain(f"{PAGE}: nothing needs the arrow from {source} to {room} in {row.folder}")
                if source in row.reachable(source):
                    self.complain(f"{PAGE}: arrows lead from {source} back to {source} in {row.folder}")
            for folder in row.uses:
                if (row.folder, folder) not in used_folders:
                    self.complain(f"{PAGE}: nothing in {row.folder} includes {folder}")

    def check_picture(self):
        drawn = set()
        for line in read(self.root / PICTURE).splitlines():
            chain = re.findall(r'"([^"\s]+/[^"\s]+)"', line) if "->" in line else []
            drawn.update(pair for pair in zip(chain, chain[1:]) if Path(pair[0]).parent == Path(pair[1]).parent)
        arrows = {
            (str(row.folder / source), str(row.folder / room)) for row in self.rows.values() for source, room in row.arrows
        }
        for source, room in sorted(drawn ^ arrows):
            where = PICTURE if (source, room) in drawn else PAGE
            self.complain(f"{where} alone has an arrow from {source} to {room}")

    def check_doors(self):
        opened = defaultdict(set)
        for path, targets in self.includes.items():
            for target in targets:
                if self.name_of(path) != self.name_of(target):
                    opened[self.name_of(target)].add((target, path))
        for row in self.rows.values():
            for room in row.rooms:
                readme = self.root / row.folder / room / "README.md"
                if not readme.is_file():
                    self.complain(f"{row.folder}/{room} has no README.md")
                    continue
                line = re.search(r"^\* Doors:(.*(?:\n  .*)*)", read(readme), re.MULTILINE)
                doors = set(quoted(line[1])) if line else set()
                entered = opened[f"{row.folder}/{room}"]
                for target, path in sorted(entered):
                    if target.name.removesuffix(".in") not in doors:
                        self.complain(f"{path} includes {target}, which its room does not name as a door")
                for door in sorted(doors - {target.name.removesuffix(".in") for target, _ in entered}):
                    self.complain(f"{row.folder}/{room}/README.md: no other room includes {door}")

    def check_heavy(self):
        """A room that the table calls free of the large libraries must not reach one through another header."""
        for row in self.rows.values():
            used = set()
            for path in (path for path, (home, _) in self.files.items() if home is row):
                _, room = self.files[path]
                inside = str(path.relative_to(row.folder))
                names = {"", room or inside, inside} & row.heavy
                guilty = next((target for target in self.reached(path) if HEAVY.search(self.texts[target])), None)
                used |= names if guilty else set()
                if guilty and not names:
                    self.complain(f"{path} reaches GStreamer, GLib or OpenCV by {guilty}")
            for name in sorted(row.heavy - used):
                self.complain(f"{PAGE}: {row.folder / name} reaches none of GStreamer, GLib and OpenCV")

    def reached(self, path):
        found, waiting = [], [path]
        while waiting:
            target = waiting.pop()
            if target not in found:
                found.append(target)
                waiting += sorted(self.includes[target])
        return found

    def check_declarations(self):
        defined, declared = defaultdict(set), []
        for path in self.files:
            if path.suffix not in (".cpp", ".hpp"):
                continue
            text = COMMENT.sub("", self.texts[path])
            for match in FUNCTION.finditer(text):
                end = re.compile(r"[;{]").search(text, match.end())
                if end and end[0] == "{":
                    defined[self.files[path][0].folder, match[1]].add(self.name_of(path))
                elif path.suffix == ".hpp":
                    declared.append((path, match[1]))
        for path, name in declared:
            rooms = defined[self.files[path][0].folder, name]
            if rooms and self.name_of(path) not in rooms:
                self.complain(f"{path} declares {name}, which {' and '.join(sorted(rooms))} defines")


def main(root):
    house = House(root)
    for problem in house.problems:
        print(problem)
    count = sum(map(len, house.includes.values()))
    print(f"{count} includes of {len(house.files)} files checked, {len(house.problems)} wrong")
    return 1 if house.problems or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]))
