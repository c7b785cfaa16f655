# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash
# What a test that is a script prints. To be sourced.

skip() {
  echo "SKIPPED: $*"
  exit 77
}

# `promise TEXT COMMAND...`: the command must succeed; the text says what that means.
promise() {
  local text=$1
  shift
  if "$@"; then
    echo "ok: $text"
  else
    echo "NOT OK: $text"
    exit 1
  fi
}
