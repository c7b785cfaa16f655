# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash
# Builds the Debian package for the tests. To be sourced.

# `build_package COMMAND...` builds the Debian package, with its unit tests, and looks at it. COMMAND runs a program in
# the folder of the sources, on the Debian of the package. The packages go to the folder above.
# A warning is an error, which it must not be for those who build a release with a later compiler. Nobody reads
# symbols for debugging of a test, and they take a third of the time. debhelper gives a build a home of its own, so
# ccache is told where the cache is.
build_package() {
  "$@" env DEB_BUILD_OPTIONS="noautodbgsym parallel=$(nproc)" \
    DEB_CFLAGS_STRIP=-g DEB_CXXFLAGS_STRIP=-g DEB_CFLAGS_APPEND=-Werror DEB_CXXFLAGS_APPEND=-Werror \
    CCACHE_DIR="${CCACHE_DIR:-${HOME:-/root}/.cache/ccache}" \
    CCACHE_SLOPPINESS=include_file_ctime,include_file_mtime,time_macros \
    dpkg-buildpackage -us -uc -b &&
    "$@" sh -c 'lintian --fail-on error,warning ../feeling-wind_*.changes'
}

# What `sh -c` runs before its arguments where there is no network but the machine itself.
# shellcheck disable=SC2034,SC2016 # for the scripts that source it; for the inner shell
only_loopback='ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'
