#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Each leak that tests/suppressions/lsan.supp excuses is one of GLib and GStreamer: excused-leaks.c, which uses nothing
# else, leaks in each of these ways and in no other.
#
# Usage: tests/referees/excused-leaks.sh
#
# Where LeakSanitizer does not run, the exit status is 77.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"
excuses=$root/tests/suppressions/lsan.supp
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The compiler of the sanitized tests.
compiler=$(command -v clang-22 || command -v gcc)
read -ra gstreamer <<<"$(pkg-config --cflags --libs gstreamer-1.0)"
"$compiler" -fsanitize=address "$root/tests/referees/excused-leaks.c" -o "$work/leaks" "${gstreamer[@]}"
status=0
GST_REGISTRY=$work/registry.bin GST_REGISTRY_FORK=no LSAN_OPTIONS=suppressions=$excuses:print_suppressions=1 \
  ASAN_OPTIONS=detect_leaks=1:intercept_tls_get_addr=0:fast_unwind_on_malloc=0 "$work/leaks" >"$work/output" 2>&1 || status=$?
! grep -q 'LeakSanitizer has encountered a fatal error' "$work/output" || skip "LeakSanitizer does not work here"
[ $status = 0 ] || { tail -n 30 "$work/output" && fail "it also leaks what lsan.supp does not excuse"; }
while read -r leak; do
  awk -v leak="$leak" '$3 == leak { found = 1 } END { exit !found }' "$work/output" ||
    { failed=yes && echo "nothing of GStreamer leaks in '$leak': take it out of lsan.supp"; }
done < <(sed -n 's/^leak://p' "$excuses")
[ $failed = no ]
