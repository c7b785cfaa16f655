#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A window from which a URI can be dragged: drag-source.py URI"""

import sys

import gi

gi.require_version("Gtk", "3.0")
gi.require_version("Gdk", "3.0")
from gi.repository import Gdk, Gtk  # noqa: E402

window = Gtk.Window(title="drag source")
window.set_default_size(120, 120)
button = Gtk.EventBox()
button.drag_source_set(Gdk.ModifierType.BUTTON1_MASK, [], Gdk.DragAction.COPY)
button.drag_source_add_uri_targets()
button.connect("drag-data-get", lambda _w, _c, data, _i, _t: data.set_uris([sys.argv[1]]))
window.add(button)
window.show_all()
Gtk.main()
