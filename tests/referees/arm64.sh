#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Builds for arm64 (Raspberry Pi 5, Jetson) with a cross compiler, in a chroot of this machine's Debian, and runs the
# unit and element tests there in qemu-user; of the room `vision` those of its vector code, which differs. Real time is
# left out, for which the emulator is too slow, and so are repetitions.
#
# Usage: tests/referees/arm64.sh [--fresh] [--cache FOLDER]
#   --fresh         makes the chroot anew; without it, one that is there is used again
#   --cache FOLDER  where the chroot is kept, about 3 GB (${XDG_CACHE_HOME:-~/.cache}/feeling-wind)
#
# Needs root. Exit status 77: it cannot run here; a line that begins with SKIPPED says why.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$root/tests/packages.sh"
source "$root/tests/referees/support.sh"
source "$root/tests/support/debian-chroot.sh"
source "$root/tests/support/repetitions.sh"

fresh=no cache=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/feeling-wind
options=("$@")
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --fresh) fresh=yes ;;
  --cache) cache=${2:?give a folder; see --help} && shift ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  shift
done
[ "$(dpkg --print-architecture)" = amd64 ] || skip "this machine is no amd64: it needs no cross compiler"
version=$(sed -n 's/^VERSION_ID="\?\([0-9]*\)"\?$/\1/p' /etc/os-release)
grep -q '^ID=debian$' /etc/os-release || skip "this machine does not run Debian"
enter_namespaces "${options[@]}"
(install_packages "${chroot_packages[@]}") || skip "packages are missing: ${chroot_packages[*]}"

mkdir -p "$cache" || fail "the folder '$cache' cannot be made; give another with --cache"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck disable=SC2034 # debian-chroot.sh takes it
chroot=$cache/debian-$version-arm64

in_chroot() {
  # shellcheck disable=SC2016 # for the inner shell
  chroot "$chroot" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb \
    sh -c 'cd /feeling-wind && exec "$@"' in_chroot "$@"
}

# What runs on the building machine, and what is linked or loaded.
here=(g++-aarch64-linux-gnu pkg-config meson ninja-build qemu-user ccache gettext python3 libeigen3-dev nlohmann-json3-dev
  dbus-daemon)
there=(libgstreamer1.0-dev libgstreamer-plugins-base1.0-dev libopencv-core-dev libopencv-imgproc-dev libopencv-video-dev
  libopencv-imgcodecs-dev libopencv-calib3d-dev libhwy-dev libusb-1.0-0-dev libgtest-dev libcairo2-dev libevdev-dev
  libumockdev-dev libglib2.0-dev gstreamer1.0-plugins-base gstreamer1.0-plugins-good gstreamer1.0-plugins-bad
  gstreamer1.0-plugins-ugly)

install_in_chroot() {
  in_chroot dpkg --add-architecture arm64 && in_chroot apt-get update -qq &&
    in_chroot apt-get install -y -qq --no-install-recommends "${here[@]}" "${there[@]/%/:arm64}"
}

build_in_chroot() {
  cat >"$chroot/feeling-wind/arm64.ini" <<'END' &&
[binaries]
c = ['ccache', 'aarch64-linux-gnu-gcc']
cpp = ['ccache', 'aarch64-linux-gnu-g++']
ar = 'aarch64-linux-gnu-ar'
strip = 'aarch64-linux-gnu-strip'
pkgconfig = 'aarch64-linux-gnu-pkg-config'
exe_wrapper = 'qemu-aarch64'
[host_machine]
system = 'linux'
cpu_family = 'aarch64'
cpu = 'aarch64'
endian = 'little'
END
    in_chroot meson setup build --cross-file arm64.ini -Dtests=enabled -Dvision=enabled -Ddevice=enabled -Dtrack=enabled \
      -Dview=disabled -Ddebug=false -Dwerror=true -Dunity=on -Dunity_size=6 -Dbenchmarks=disabled &&
    in_chroot ninja -C build
}

# `test_in_chroot FILTER OPTION...`
test_in_chroot() {
  in_chroot env GTEST_FILTER="$1" meson test -C build --no-rebuild --print-errorlogs --timeout-multiplier 20 \
    --no-suite realtime "${@:2}"
}

promise "a chroot of Debian $version is there" make_chroot
promise "the tree is copied" copy_tree "$chroot/feeling-wind"
promise "the packages are installed" install_in_chroot
promise "everything builds for arm64 without a warning" build_in_chroot
promise "unit and element tests pass there" test_in_chroot "$(without_repetitions)" \
  --suite unit --suite elements --no-suite unit-vision
promise "the vector code works there" test_in_chroot "$(cases_of "${vector_tests[@]}")-$vector_repetitions" \
  --suite unit-vision
