#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Builds the Debian packages for this machine, in a copy of the tree and without a network. The build runs the unit
# tests and has no warning; lintian finds nothing.
#
# Usage: tests/debian-package.sh [FOLDER]
#   FOLDER  where the packages go (build-packages); packages that are there are removed
#
# Exit status 77: it cannot run here; a line that begins with SKIPPED says why.

source "$(dirname "$0")/../pipelines/shared/common.sh"
source "$(dirname "$0")/packages.sh"
source "$(dirname "$0")/support/promise.sh"
source "$(dirname "$0")/support/debian-chroot.sh"
source "$(dirname "$0")/support/debian-package.sh"

case ${1:-} in
--help | -h) show_help && exit ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
mkdir -p "${1:-$root/build-packages}" || fail "the folder '$1' cannot be made; give another"
folder=$(cd "${1:-$root/build-packages}" && pwd)
offline=(unshare --net)
[ "$(id -u)" = 0 ] || offline=(unshare --map-root-user --net)
"${offline[@]}" true 2>/dev/null || skip "this machine does not allow a namespace without a network"
(install_packages "${package_packages[@]}" "${build_packages[@]}" "${view_packages[@]}" libgtest-dev dbus-daemon iproute2) ||
  skip "packages are missing"

rm -f "$folder"/{feeling-wind,libspidar}[-_0]*.{deb,changes,buildinfo}
trap 'rm -rf "$folder/source"' EXIT
in_copy() {
  (cd "$folder/source" && "${offline[@]}" sh -c "$only_loopback" in_copy "$@")
}
copy_tree "$folder/source"
if ! build_package in_copy >"$folder/build.log" 2>&1 </dev/null; then
  # Other commands were still running when one failed: its message is not the last.
  grep -A 30 '^FAILED:' "$folder/build.log" || tail -n 60 "$folder/build.log"
  fail "the package could not be built; read the log $folder/build.log"
fi
ls "$folder"/*.deb
