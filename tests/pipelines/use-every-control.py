#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Presses every key of feeling-wind and clicks every button and menu item, with events of the window system's server.

use-every-control.py PROGRAM VIDEO. The window is at the display of DISPLAY, or, with WAYLAND_DISPLAY, in a weston that
is a window there, with a background of #ff00ff and without panel. A key or a control that is not in the tables below is
a failure. Screenshots are left in the current folder.
"""

import os
import re
import signal
import socket
import subprocess
import sys
import time

import gi
import numpy

gi.require_version("Atspi", "2.0")
from gi.repository import Atspi  # noqa: E402

PROGRAM, VIDEO = sys.argv[1:]
WAYLAND = "WAYLAND_DISPLAY" in os.environ
PATIENCE = 60  # s; meant for a machine with other work
DIALOG, MENU, FULL_SCREEN, END = "a dialog", "a menu", "full screen", "the end"

# What each action writes with --verbose, or shows. The names are those of --help and of the menu.
ACTIONS = {
    "Open a film": DIALOG,
    "Open a URL (http, https, rtsp)": DIALOG,
    "Choose a camera": MENU,
    "Pause, play": "paused|playing",
    "5 s back": "at 0:",
    "5 s forward": "at 0:",
    "To the beginning": "at 0:00",
    "Slower": "playing at [-.0-9]+ times",
    "Faster": "playing at [-.0-9]+ times",
    "Reverse the direction": "playing at [-.0-9]+ times",
    "Turn the film by 90°": "rotation",
    "Deinterlace: automatic, always, never": "first frame",
    "Sound off and on": "sound (on|off)",
    "Quieter": "sound at",
    "Louder": "sound at",
    "Record film and track, end the recording": DIALOG,
    "Force off and on": "force (on|off)",
    "Force off; leave full screen": "force off",
    "Hold what is under the pointer, let go": "held until|let go",
    "Weaker": "strength",
    "Stronger": "strength",
    "Smaller region": "region of [0-9]+ px",
    "Larger region": "region of [0-9]+ px",
    "Region of the default size": "region of the default size",
    "Next force law": "force law",
    "Choose a device": MENU,
    "Calibrate: the grip is in the centre now": "the grip is in the centre",
    "Full screen": FULL_SCREEN,
    "Motion and force drawn over the film": "motion and force are drawn|the film alone",
    "Curves": "with(out)? curves",
    "Menu": MENU,
    "Keys": DIALOG,
    "Like the desktop, light, dark": "colours",
    "About Feeling Wind": DIALOG,
    "Film of the demonstration": "Drawing the film|wind-film draws|is drawn; the menu",
    "ring-8": "array ring-8",
    "None": "without an array",
    "Quit": END,
}
# The actions of the buttons whose names are others.
BUTTONS = {
    "Play": "Pause, play",
    "Pause": "Pause, play",
    "Record": "Record film and track, end the recording",
    "Camera": "Choose a camera",
    "Haptic device": "Choose a device",
    "Switch force off": "Force off and on",
    "Switch force on": "Force off and on",
    "Open a URL": "Open a URL (http, https, rtsp)",
    "Open another …": "Open a film",
    "Play the film of the demonstration": "Film of the demonstration",
    "Close": "Quit",
}
KEYPAD = {"Slower": "KP_Subtract", "Faster": "KP_Add", "Region of the default size": "KP_0"}
KEY_NAMES = {"-": "minus", "+": "plus", "=": "equal", "<": "less", ">": "greater", "[": "bracketleft",
             "]": "bracketright", ",": "comma", ".": "period"}
OF_THE_TITLE_BAR = ("Minimize", "Maximize")
CONTROLS = (Atspi.Role.PUSH_BUTTON, Atspi.Role.TOGGLE_BUTTON, Atspi.Role.SLIDER)
ITEMS = (Atspi.Role.MENU_ITEM, Atspi.Role.CHECK_MENU_ITEM, Atspi.Role.RADIO_MENU_ITEM)


def until(what, condition):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        result = condition()
        if result:
            return result
        time.sleep(0.05)
    screenshot("failed")
    sys.exit(f"the program wrote:\n{said()}\nthis did not happen within {PATIENCE} s: {what}")


def xdotool(*words):
    subprocess.run(["xdotool", *map(str, words)], check=True)


# A key is down for some time, as a person presses it: a compositor opens no menu for a key that is already up.
def press(key):
    xdotool("keydown", key, "sleep", 0.1, "keyup", key)


def screenshot(name):
    source = ["ximagesrc", "num-buffers=1", "use-damage=false", "show-pointer=false", "!", "videoconvert", "!"]
    subprocess.run(["gst-launch-1.0", "-q", *source, "tee", "name=t", "!", "queue", "!", "pngenc", "!", "filesink",
                    f"location={name}.png", "t.", "!", "queue", "!", "videoconvert", "!", "video/x-raw,format=RGB",
                    "!", "filesink", f"location={name}.rgb"], check=True)
    pixels = numpy.fromfile(f"{name}.rgb", numpy.uint8)
    os.remove(f"{name}.rgb")
    width, height = map(int, subprocess.check_output(["xdotool", "getdisplaygeometry"]).split())
    return pixels.reshape(height, width, 3)


# ---- what a screen reader finds -----------------------------------------------------------------

def nodes(node, roles):
    try:
        if not node or not node.get_state_set().contains(Atspi.StateType.SHOWING):
            return
        if node.get_role() in roles:
            yield node
        for i in range(node.get_child_count()):
            yield from nodes(node.get_child_at_index(i), roles)
    except gi.repository.GLib.Error:  # it has just gone
        return


def windows():
    desktop = Atspi.get_desktop(0)
    for i in range(desktop.get_child_count()):
        application = desktop.get_child_at_index(i)
        if application and application.get_name() == "feeling-wind":
            for j in range(application.get_child_count()):
                window = application.get_child_at_index(j)
                if window and window.get_state_set().contains(Atspi.StateType.SHOWING):
                    yield window


def main_window():
    return next((window for window in windows() if window.get_role() == Atspi.Role.FRAME), None)


def controls():
    return list(nodes(main_window(), CONTROLS))


def items():
    return [item for window in windows() for item in nodes(window, ITEMS)]


def dialogs():
    roles = (Atspi.Role.DIALOG, Atspi.Role.FILE_CHOOSER, Atspi.Role.FRAME, Atspi.Role.ALERT)
    return [window for window in windows() if window.get_role() in roles][1:]


def extents(node):
    area = node.get_extents(Atspi.CoordType.SCREEN)
    return area.x, area.y, area.width, area.height


# ---- the mouse ----------------------------------------------------------------------------------

# A client of Wayland does not know where its window is: the first row and column that are not background, nor its
# shadow, are those of the bar at the top.
def origin():
    if not WAYLAND:
        return 0, 0
    pixels = screenshot("origin").astype(int)
    background = (pixels[:, :, 0] == pixels[:, :, 2]) & (pixels[:, :, 1] == 0)
    rows, columns = ((~background).sum(axis=axis) for axis in (1, 0))
    bar = next(nodes(main_window(), (Atspi.Role.PANEL,)))
    x, y, _, _ = extents(bar)
    return int(numpy.argmax(columns > 100)) - x, int(numpy.argmax(rows > 100)) - y


def settled(what):
    before = None
    while before != (before := what()):
        time.sleep(0.3)
    return before


def click(node, corner=None, part=0.5):
    left, top = corner or settled(origin)
    x, y, width, height = settled(lambda: extents(node))
    x, y = left + x + int(part * width), top + y + height // 2
    xdotool("mousemove", x - 2, y, "sleep", 0.05, "mousemove", x, y, "sleep", 0.1, "click", 1)


# ---- the program --------------------------------------------------------------------------------

def said():
    with open("said", encoding="utf-8") as file:
        return file.read()


def start(*arguments):
    global process
    with open("said", "w", encoding="utf-8") as file:
        process = subprocess.Popen([PROGRAM, "--verbose", *arguments], stdout=file, stderr=subprocess.STDOUT)
    until("a window", main_window)
    if VIDEO in arguments:
        until("a first frame", lambda: "first frame" in said())
    settled(lambda: extents(main_window()))
    width, height = map(int, subprocess.check_output(["xdotool", "getdisplaygeometry"]).split())
    # Weston counts the steps of the mouse: in both corners its place is known.
    xdotool("mousemove", 0, 0, "sleep", 0.1, "mousemove", width - 1, height - 1, "sleep", 0.1,
            "mousemove", width // 2, height // 2)


def ended():
    if process.poll() is None:
        return False
    if process.returncode != 0:
        sys.exit(f"{said()}\nit ended with status {process.returncode}")
    return True


def is_full():
    left, top, width, height = extents(main_window())
    screen = os.environ["SCREEN_SIZE"].split("x")
    return [width, height] == list(map(int, screen))


# While the window is laid out anew, or on a busy machine, a click or a key may miss; a person repeats it.
def insist(what, do, condition):
    for _ in range(3):
        do()
        end = time.monotonic() + PATIENCE / 4
        while time.monotonic() < end:
            if condition():
                return
            time.sleep(0.05)
    until(what, condition)


# Does something, and waits for what is to follow. Leaves the window as it was.
def check(name, do):
    expected = ACTIONS[BUTTONS.get(name, name)]
    print(f"{name}: {expected}", flush=True)
    if expected == ACTIONS["Record film and track, end the recording"] and name.startswith("Record"):
        to_normal_speed()
    before, was_full = said(), is_full()
    if expected == END:
        do()
        until(f"the end after {name}", ended)
    elif expected == FULL_SCREEN:
        insist("full screen", do, lambda: is_full() != was_full)
    elif expected in (DIALOG, MENU):
        shown = dialogs if expected == DIALOG else items
        insist(f"{expected} after {name}", do, shown)
        screenshot(re.sub("[^A-Za-z]+", "-", name).strip("-").lower())
        insist(f"it goes after {name}", lambda: press("Escape"), lambda: not shown())
    else:
        insist(f"{expected} after {name}", do, lambda: re.search(expected, said()[len(before):]))


def to_normal_speed():
    while (rates := re.findall("playing at ([-.0-9]+) times", said())) and float(rates[-1]) != 1:
        rate = float(rates[-1])
        check("Slower", lambda: press("r" if rate < 0 else "minus" if rate > 1 else "plus"))


# ---- the tests ----------------------------------------------------------------------------------

def keys_of_help():
    text = subprocess.check_output([PROGRAM, "--help"], text=True)
    for line in text[text.index("Keys:"):].splitlines():
        if match := re.fullmatch(r"  (\S+(?: or \S+)*) +(.*)", line):
            yield match[2], match[1].split(" or ")


def key_name(label):
    label = KEY_NAMES.get(label, label)
    if label.startswith("Ctrl+"):
        return "ctrl+" + ("question" if label[-1] == "?" else label[-1].lower())
    return label


def use_keys():
    start(VIDEO)
    screenshot("window")
    found = list(keys_of_help())
    for name, labels in found:
        for label in [key_name(label) for label in labels] + ([KEYPAD[name]] if name in KEYPAD else []):
            if ACTIONS[name] == END:
                start(VIDEO) if process.poll() is not None else None
            check(name, lambda key=label: press(key))
            if ACTIONS[name] == FULL_SCREEN:
                screenshot("full-screen")
                check("Full screen", lambda: press("Escape"))
    if len(found) < 30:
        sys.exit("the keys of --help are not understood")


def use_buttons():
    start(VIDEO)
    names = [control.get_name() for control in controls()]
    for i, name in sorted(enumerate(names), key=lambda pair: pair[1] == "Close"):
        if name in OF_THE_TITLE_BAR:
            continue
        if name.startswith("Position"):
            check("To the beginning", lambda: press("Home"))  # a click at the place where the film is changes nothing
            check("5 s forward", lambda index=i: click(controls()[index], part=0.8))
        else:
            check(name, lambda index=i: click(controls()[index]))
            if name == "Full screen":
                leave = next(control for control in controls() if control.get_name() == "Leave full screen")
                check("Full screen", lambda control=leave: click(control, corner=(0, 0)))


def use_menu():
    start(VIDEO)

    def open_menu():
        corner = settled(origin)
        menu = next(control for control in controls() if control.get_name() == "Menu")
        click(menu, corner=corner)
        until("the menu", items)
        return corner

    # Weston lets a menu reach beyond the screen, and puts a submenu elsewhere than GTK says.
    def choose_with_keys(name):
        def is_selected():
            for entry in (entry for window in windows() for entry in nodes(window, (*ITEMS, Atspi.Role.MENU))):
                if entry.get_name() == name and entry.get_state_set().contains(Atspi.StateType.SELECTED):
                    return True
            press("Down")
            return False
        until(f"{name} is selected", is_selected)
        press("Return")

    def is_on_screen(node, corner):
        size = map(int, os.environ["SCREEN_SIZE"].split("x"))
        x, y, width, height = settled(lambda: extents(node))
        return all(0 <= at < most for at, most in zip((corner[0] + x + width // 2, corner[1] + y + height // 2), size))

    open_menu()
    names = [item.get_name() for item in items()]
    press("Escape")
    until("no menu", lambda: not items())
    for name in ("ring-8", "None"):
        def choose_array(name=name):
            open_menu()
            choose_with_keys("Array of actuators")
            choose_with_keys(name)
        check(name, choose_array)
    for i, name in sorted(enumerate(names), key=lambda pair: pair[1] == "Quit"):
        def choose(index=i, name=name):
            corner = open_menu()
            item = items()[index]
            if is_on_screen(item, corner):
                click(item, corner=corner)
            else:
                choose_with_keys(name)
        check(name, choose)
    if len(names) < 20:
        sys.exit(f"the menu has {names}")


# Tab reaches every control, and Space presses it.
def use_tab():
    start(VIDEO)
    wanted = {control.get_name() for control in controls()} - {"Close", *OF_THE_TITLE_BAR}  # there are keys of the desktop for them
    reached = []
    for _ in range(3 * len(wanted)):
        focused = [control.get_name() for control in controls()
                   if control.get_state_set().contains(Atspi.StateType.FOCUSED)]
        reached += focused
        if focused == ["Stronger"]:
            check("Stronger", lambda: press("space"))
        if wanted <= set(reached):
            break
        press("Tab")
    else:
        sys.exit(f"Tab does not reach {wanted - set(reached)}, only {reached}")
    process.send_signal(signal.SIGINT)
    until("the end", ended)


# What is seen without a film, and beside an error and a film that does not come.
def use_other_pages():
    start()
    screenshot("empty")
    names = [control.get_name() for control in controls()]
    for i, name in enumerate(names):
        usable = controls()[i].get_state_set().contains(Atspi.StateType.SENSITIVE)
        if name in ("Open a film", "Open a URL") and usable:
            check(name, lambda index=i: click(controls()[index]))
    process.send_signal(signal.SIGINT)
    until("the end", ended)

    def use_bar(name, condition):
        until(name, lambda: name in [control.get_name() for control in controls()])
        screenshot("bar-" + name.split()[0].lower())
        bar = next(control for control in controls() if control.get_name() == name)
        if condition == DIALOG:
            check(name, lambda: click(bar))
        else:
            click(bar)
        until("no bar", lambda: name not in [control.get_name() for control in controls()])

    start(VIDEO + ".missing")
    use_bar("Open another …", DIALOG)
    process.send_signal(signal.SIGINT)
    until("the end", ended)
    with socket.create_server(("127.0.0.1", 0)) as server:
        start(f"http://127.0.0.1:{server.getsockname()[1]}/film.mp4")
        use_bar("Go on waiting", None)
        process.send_signal(signal.SIGINT)
        until("the end", ended)


process = None
try:
    use_keys()
    use_buttons()
    use_menu()
    use_tab()
    use_other_pages()
finally:
    if process and process.poll() is None:
        process.kill()
