#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Makes a chroot of the Debian that this machine does not run (13 on Debian 12, 12 on Debian 13) and builds the Debian
# package there, without a warning and with its unit tests. Runs the element and pipeline tests there in the folder
# where the package was built. Installs the package there, and checks what it gives a user. Closes with one line:
# N passed, N failed, N skipped. The exit status is 0 only when nothing failed.
#
# Usage: tests/other-debian.sh [--part build|tests] [--fresh] [--cache FOLDER]
#   --part          only builds the package, or only runs the tests of a build that is there
#   --fresh         makes the chroot anew; without it, one that is there is used again
#   --cache FOLDER  where the chroot is kept, about 3 GB (${XDG_CACHE_HOME:-~/.cache}/feeling-wind)
#
# Needs root. The packages come from the archive that apt uses on this machine, with apt's settings. Builds and
# tests have no network. Exit status 77: it cannot run here; a line that begins with SKIPPED says why.

source "$(dirname "$0")/../pipelines/shared/common.sh"
source "$(dirname "$0")/packages.sh"
source "$(dirname "$0")/support/promise.sh"
source "$(dirname "$0")/support/repeat.sh"
source "$(dirname "$0")/support/debian-chroot.sh"
source "$(dirname "$0")/support/debian-package.sh"

part=all fresh=no cache=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/feeling-wind

read_options() {
  while [ $# -gt 0 ]; do
    case $1 in
    --help | -h) show_help && exit ;;
    --part)
      part=${2:-}
      [[ $part = build || $part = tests ]] || fail "--part is build or tests; see --help"
      shift
      ;;
    --fresh) fresh=yes ;;
    --cache)
      cache=${2:-}
      [ -n "$cache" ] || fail "--cache needs a folder; see --help"
      shift
      ;;
    *) fail "unknown option '$1'; see --help" ;;
    esac
    shift
  done
}

# Puts the other version into $version.
choose_version() {
  local id number
  id=$(sed -n 's/^ID=//p' /etc/os-release)
  number=$(sed -n 's/^VERSION_ID="\?\([0-9]*\)"\?$/\1/p' /etc/os-release)
  case $id-$number in
  debian-12) version=13 ;;
  debian-13) version=12 ;;
  *) skip "this machine runs neither Debian 12 nor Debian 13" ;;
  esac
}

passed=0 failed=0 skipped=0

finish() {
  [ "$1" = 0 ] || [ "$failed" -gt 0 ] || failed=1
  rm -rf "$work"
  echo
  echo "$passed passed, $failed failed, $skipped skipped"
  [ "$failed" = 0 ] || exit 1
}

# Runs a command as one test. Its output goes to a log, whose end is shown when it fails.
check() {
  local name=$1 log=$cache/log/$2.txt began=$SECONDS
  shift
  printf '\n== %s\n' "$name"
  if "$@" >"$log" 2>&1 </dev/null; then
    echo "ok: $name ($((SECONDS - began)) s)"
    passed=$((passed + 1))
  else
    tail -n 40 "$log"
    echo "FAILED: $name (log: $log)"
    failed=$((failed + 1))
    return 1
  fi
}

# Runs a command in the chroot, in the folder of the source.
in_chroot() {
  # shellcheck disable=SC2016 # for the inner shell
  "${enter[@]}" 'cd /feeling-wind && exec "$@"' in_chroot "$@"
}

# The same, without a network.
offline_in_chroot() {
  # shellcheck disable=SC2154 # it is in debian-package.sh
  unshare --net "${enter[@]}" "cd /feeling-wind && $only_loopback" offline_in_chroot "$@"
}

# Without the packages of an earlier run, which tests of a build would find.
make_clean_chroot() {
  local names
  mapfile -t names < <(sed -n 's/^Package: //p' "$root/debian/control")
  # shellcheck disable=SC2016 # for the inner shell
  make_chroot && "${enter[@]}" 'exec dpkg --purge "$@"' purge "${names[@]}"
}

copy_tree_and_film() {
  local name file
  copy_tree "$chroot/feeling-wind" && mkdir "$chroot/feeling-wind/build-data" || return
  for name in tree.avi aloeL.jpg aloeGT.png; do
    file=$(opencv_file $name) && cp "$file" "$chroot/feeling-wind/build-data/" || return
  done
}

# By the project's own script, as on any machine.
install_in_chroot() {
  local packages=("${run_packages[@]}" "${build_packages[@]}" "${view_packages[@]}" "${package_packages[@]}"
    "${chroot_packages[@]}" "${server_packages[@]}" ccache
    libgstreamer-plugins-bad1.0-dev) # GstAnalytics, since GStreamer 1.24
  local package
  for package in "${test_packages[@]}"; do
    case $package in
    clang-* | shellcheck) ;; # they look at the source, which is the same
    *) packages+=("$package") ;;
    esac
  done
  # shellcheck disable=SC2016 # for the inner shell
  in_chroot bash -c 'source pipelines/shared/common.sh && source tests/packages.sh && install_packages "$@" && apt-get clean' \
    install "${packages[@]}"
}

package_in_chroot() {
  rm -f "$chroot"/{feeling-wind,libspidar}[-_0]*.*
  build_package offline_in_chroot
}

# `count_tests STATUS` counts what meson wrote down before it ended so.
count_tests() {
  local outcomes outcome
  outcomes=$("$root/tests/summary.py" collect '' "$chroot/feeling-wind/$built/meson-logs" "$(mktemp -d -p "$work")")
  sed -n 's/^passed\t\([^\t]*\)\t.*\tpassed alone$/repeated: \1 (passed alone)/p' <<<"$outcomes"
  for outcome in passed skipped failed; do
    printf -v "$outcome" %d $((${!outcome} + $(grep -c "^$outcome" <<<"$outcomes" || true)))
  done
  # A run that went wrong without a failed test still is a failure, and so is one without a test.
  [[ $1 = 0 && -n $outcomes ]] || failed=$((failed + 1))
}

# One at a time, since some are of real time.
run_tests_in_chroot() {
  local status=0
  printf '\n== Element and pipeline tests on Debian %s\n' "$version"
  run_and_repeat "$chroot/feeling-wind/$built/meson-logs" 1 offline_in_chroot meson test -C "$built" --no-rebuild \
    --print-errorlogs --timeout-multiplier 3 --suite elements --suite pipelines || status=1
  count_tests "$status"
}

check_installed_in_chroot() {
  offline_in_chroot sh -c 'dpkg --install ../feeling-wind[-_]*.deb ../libspidar*.deb' &&
    offline_in_chroot tests/installed-package.sh
}

read_options "$@"
choose_version
enter_namespaces "$@"

mkdir -p "$cache/log" || fail "the folder '$cache' cannot be made; give another with --cache"
cache=$(cd "$cache" && pwd)
exec 9>"$cache/lock"
flock --nonblock 9 || skip "another run uses the chroot in $cache"
(install_packages "${chroot_packages[@]}") || skip "packages are missing: ${chroot_packages[*]}"
work=$cache/work
rm -rf "$work"
mkdir "$work"
trap 'finish $?' EXIT
chroot=$cache/debian-$version
enter=(chroot "$chroot" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb sh -c)

check "A chroot of Debian $version is there" make_clean_chroot
if [ "$part" != tests ]; then
  check "The tree is copied" copy_tree_and_film
  check "The packages are installed on Debian $version" install_in_chroot
  check "The Debian package builds without a warning on Debian $version, and its unit tests pass" package_in_chroot
fi
built=$(cd "$chroot/feeling-wind" && echo obj-*)
[ "$part" = tests ] || count_tests 0
if [ "$part" != build ]; then
  run_tests_in_chroot
  check "The Debian package serves its users on Debian $version" check_installed_in_chroot
fi
