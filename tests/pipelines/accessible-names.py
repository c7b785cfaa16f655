#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lists the controls of feeling-wind as a screen reader finds them. Fails if one has no name."""

import sys

import gi

gi.require_version("Atspi", "2.0")
from gi.repository import Atspi  # noqa: E402

nameless = found = 0


def visit(node, depth):
    global nameless, found
    state = node.get_state_set()
    usable = state.contains(Atspi.StateType.VISIBLE) and state.contains(Atspi.StateType.FOCUSABLE)
    if usable and node.get_role() != Atspi.Role.PANEL:
        found += 1
        nameless += not node.get_name()
    print("  " * depth + node.get_role_name(), repr(node.get_name()))
    for i in range(node.get_child_count()):
        visit(node.get_child_at_index(i), depth + 1)


desktop = Atspi.get_desktop(0)
for i in range(desktop.get_child_count()):
    application = desktop.get_child_at_index(i)
    if application.get_name() == "feeling-wind":
        visit(application, 0)
print(f"{found} controls, {nameless} without a name")
sys.exit(nameless > 0 or found < 20)
