#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Measures the first minute of a newcomer, in a Debian that has just been made and git:
# 1. from `git clone` to the first frame in a window and to the first force above 50 mN, by the one command
#    pipelines/view.sh, which installs packages, builds, and draws the film;
# 2. with --packages, from the installed packages of the project to the first frame of that film.
# The window is on an X server of this machine. The time to make that Debian and to load git is left out.
#
# Usage: tests/measure/benchmarks/first-minute.sh [--debian 12|13] [--packages FOLDER] [--cache FOLDER]
#   --debian           the version (12)
#   --packages FOLDER  where the project's packages of that version are, as dpkg-buildpackage leaves them
#   --cache FOLDER     where the chroot is made, about 3 GB (${XDG_CACHE_HOME:-~/.cache}/feeling-wind)
#
# Needs root and the network. The packages come from the archive that apt uses on this machine.

source "$(dirname "$0")/../../../pipelines/shared/common.sh"
source "$(dirname "$0")/../../packages.sh"
source "$(dirname "$0")/../../support/promise.sh"
source "$(dirname "$0")/../../support/debian-chroot.sh"

given=("$@") version=12 packages='' cache=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/feeling-wind
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --debian) version=${2:-} ;;
  --packages) packages=${2:-} ;;
  --cache) cache=${2:-} ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  shift $(($# > 1 ? 2 : 1))
done
[[ $version = 12 || $version = 13 ]] || fail "--debian is 12 or 13; see --help"
[ -z "$packages" ] || ls "$packages"/feeling-wind_*.deb >/dev/null 2>&1 ||
  fail "'$packages' has no package of feeling-wind; see --help"
[ -n "$cache" ] || fail "--cache needs a folder; see --help"
enter_namespaces "${given[@]}"

mkdir -p "$cache" || fail "the folder '$cache' cannot be made; give another with --cache"
(install_packages "${chroot_packages[@]}" xvfb) || fail "packages are missing"
# shellcheck disable=SC2034 # for make_chroot
fresh=yes work=$(mktemp -d) chroot=$(cd "$cache" && pwd)/first-minute-$version
finish() {
  [ "$1" = 0 ] || tail -n 30 "$work"/*.log
  rm -rf "$work"
  # What is mounted there must not be removed.
  umount -R "$chroot/proc" "$chroot/sys" "$chroot/dev" 2>/dev/null || exit "$1"
  rm -rf --one-file-system "$chroot" "$chroot.part"
}
trap 'finish $?' EXIT
inside() {
  chroot "$chroot" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb \
    DISPLAY="$display" NO_AT_BRIDGE=1 GSETTINGS_BACKEND=memory "$@"
}

make_chroot >"$work/chroot.log" 2>&1
git clone -q --bare "$root" "$chroot/source.git"
Xvfb -displayfd 3 -screen 0 1920x1080x24 -noreset -ac 3>"$work/display" >"$work/server.log" 2>&1 &
for _ in {1..100}; do
  [ ! -s "$work/display" ] || break
  sleep 0.1
done
display=:$(<"$work/display")
inside sh -c 'apt-get -q update && apt-get -qy install --no-install-recommends git ca-certificates' >"$work/git.log" 2>&1
echo "Debian $version, $(nproc) processors"

# `seconds_until COMMAND...`: when the command first succeeds, in seconds after $began.
seconds_until() {
  until "$@"; do
    kill -0 "$viewer" || return
    sleep 0.1
  done
  echo $((EPOCHSECONDS - began))
}
installed() {
  [ -d "$chroot/feeling-wind/build" ]
}
built() {
  [ -x "$chroot/feeling-wind/build/pipelines/feeling-wind/feeling-wind" ]
}
shown() {
  grep -q 'first frame' "$work/view.log"
}
felt() {
  [ -s "$chroot/force.csv" ] &&
    awk -F, 'NR > 1 && $8 * $8 + $9 * $9 > 0.05 ^ 2 { found = 1; exit } END { exit !found }' "$chroot/force.csv"
}
began=$EPOCHSECONDS
inside sh -c 'git clone -q /source.git feeling-wind && cd feeling-wind &&
  exec pipelines/view.sh --verbose -- log-location=/force.csv' >"$work/view.log" 2>&1 &
viewer=$!
echo "the packages are installed after $(seconds_until installed) s"
echo "the program is built after $(seconds_until built) s"
echo "the first frame is shown after $(seconds_until shown) s"
echo "the first force is felt after $(seconds_until felt) s"
pkill -INT -P "$viewer"
wait "$viewer" || true

[ -n "$packages" ] || exit 0
mv "$chroot/feeling-wind/build-data/wind.ts" "$chroot/wind.ts"
cp "$packages"/*.deb "$chroot/"
inside sh -c 'apt-get -qy install ./*.deb' >"$work/packages.log" 2>&1
inside env FIRST_FRAME_DISPLAY=yes /feeling-wind/tests/measure/benchmarks/first-frame.sh /wind.ts
