# SPDX-License-Identifier: LGPL-2.1-or-later
# Leaves comments and indentation out of a module for viewers: blocks of /**, lines of // but the first, which has the
# licence, and what stands behind code after " // ".
/^ *\/\*\*.*\*\/$/d
/^ *\/\*\*/,/\*\/$/d
2,${
  /^ *\/\//d
  s/ \/\/ .*//
}
s/^ *//
