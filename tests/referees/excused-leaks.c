// SPDX-License-Identifier: LGPL-2.1-or-later
// Leaks with GLib and GStreamer alone in each way that tests/suppressions/lsan.supp excuses, if
// GST_REGISTRY names a file that does not exist (excused-leaks.sh).
#include <gst/gst.h>
#include <stdio.h>

#define NAMES 5000 // GLib's table grows with each 2048

static void keep(void (*way)(const char *), char prefix) {
  for (int i = 0; i < NAMES; ++i) {
    char name[16];
    snprintf(name, sizeof name, "%c%d", prefix, i);
    way(name);
  }
}

static void quark(const char *name) {
  g_quark_from_string(name);
}
static void static_quark(const char *name) {
  g_quark_from_static_string(g_strdup(name));
}
static void intern(const char *name) {
  g_intern_string(name);
}
static void static_intern(const char *name) {
  g_intern_static_string(g_strdup(name));
}

int main(void) {
  gst_init(NULL, NULL);
  keep(quark, 'a');
  keep(static_quark, 'b');
  keep(intern, 'c');
  keep(static_intern, 'd');
  return 0;
}
