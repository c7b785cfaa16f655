# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # $failed is read by the tests that source it
# What the tests of spidar-info and spidar-calibrate share. To be sourced.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# `expect STATUS TEXT COMMAND...`: its exit status, and what it must say.
expect() {
  local status=0 wanted=$1 text=$2
  shift 2
  "$@" >"$work/output" 2>&1 || status=$?
  if [ "$status" != "$wanted" ] || ! grep -qF -- "$text" "$work/output"; then
    echo "FAILED: $*"
    echo "  status $status instead of $wanted, or '$text' is missing in:"
    sed 's/^/  | /' "$work/output"
    failed=1
  fi
}
