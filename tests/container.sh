#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Builds the image of pipelines/batch/Containerfile with buildah, authors a film in it, and checks what its Debian
# package gives a user. Where its base image cannot be loaded, one is made of Debian's packages.
#
# Usage: tests/container.sh [--packages FOLDER] [--cache FOLDER]
#   --packages FOLDER  what tests/debian-package.sh has built; on Debian 12, as in the image, nothing is built again
#   --cache FOLDER     where images are kept, about 3 GB (${XDG_CACHE_HOME:-~/.cache}/feeling-wind)
#
# Needs root, buildah and the network. Exit status 77: it cannot run here; a line that begins with SKIPPED says why.

source "$(dirname "$0")/../pipelines/shared/common.sh"
source "$(dirname "$0")/packages.sh"
source "$(dirname "$0")/support/promise.sh"
source "$(dirname "$0")/support/debian-chroot.sh"

given=("$@") packages='' cache=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/feeling-wind
while [ $# -gt 0 ]; do
  case $1 in
  --help | -h) show_help && exit ;;
  --packages)
    packages=${2:-}
    ls "$packages"/feeling-wind_*.deb >/dev/null 2>&1 || fail "'$packages' has no package of feeling-wind; see --help"
    shift
    ;;
  --cache)
    cache=${2:-}
    [ -n "$cache" ] || fail "--cache needs a folder; see --help"
    shift
    ;;
  *) fail "unknown option '$1'; see --help" ;;
  esac
  shift
done
[ -z "$packages" ] || grep -q '^VERSION_ID="12"' /etc/os-release || packages='' # they are of another Debian
command -v buildah >/dev/null || skip "buildah is not installed"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"
enter_namespaces "${given[@]}"
(install_packages "${chroot_packages[@]}") || skip "packages are missing: ${chroot_packages[*]}"

mkdir -p "$cache" || fail "the folder '$cache' cannot be made; give another with --cache"
work=$(mktemp -d -p "$cache")
unmount_base() {
  umount -R "$work/base/sys" && umount -R "$work/base/dev" && umount "$work/base/proc"
}
# shellcheck disable=SC2317 # the trap calls it
finish() {
  # What is mounted there must not be removed.
  ! mountpoint -q "$work/base/dev" || unmount_base || return
  rm -rf --one-file-system "$work"
}
trap finish EXIT
export BUILDAH_ISOLATION=chroot # it needs no more than root
images() {
  buildah --storage-driver vfs --root "$cache/images" --runroot "$work/run" "$@"
}
base=$(sed -n 's/^FROM \([^ ]*\) AS build$/\1/p' "$root/pipelines/batch/Containerfile")
author=localhost/feeling-wind-author

# The base image, of a Debian with the settings of this machine.
# shellcheck disable=SC2034 # for make_chroot
make_base() {
  local version=12 fresh=yes chroot=$work/base container
  make_chroot && unmount_base || return
  container=$(images from scratch) && images add --quiet "$container" "$chroot" / >/dev/null &&
    images commit --quiet --rm "$container" "$base"
}
base_is_there() {
  images inspect --type image "$base" >/dev/null 2>&1 || images pull --quiet "$base" 2>"$work/pull.log" || {
    tail -n 1 "$work/pull.log"
    make_base >"$work/base.log" 2>&1 || { tail -n 20 "$work/base.log"; return 1; }
  }
}
built() {
  local arguments=()
  copy_tree "$work/source"
  if [ -n "$packages" ]; then
    mkdir "$work/source/packages" && cp "$packages"/*.deb "$work/source/packages/" || return
    arguments=(--build-arg packages=packages)
  fi
  images build --pull-never --layers=false "${arguments[@]}" --file "$work/source/pipelines/batch/Containerfile" \
    --tag "$author" "$work/source" >"$work/build.log" 2>&1 || { tail -n 30 "$work/build.log"; return 1; }
}
inside() {
  images run --volume "$work/films:/films" "$container" haptic-track "$@"
}
authored() {
  mkdir "$work/films"
  ffmpeg -v error -f lavfi -i testsrc2=size=320x240:rate=30:duration=2 -c:v libx264 -g 30 "$work/films/film.mp4" </dev/null
  container=$(images from --pull-never "$author")
  inside author /films/film.mp4 && inside info /films/film.haptic.ts | tee "$work/info" && grep -q '^ *fields  *60$' "$work/info"
}
# With GStreamer's tools, and with the program where its package is given.
serves_users() {
  # shellcheck disable=SC2016 # for the inner shell
  images run --volume "$work/source:/source:ro" "$container" sh -c 'apt-get -q update &&
    apt-get -qy install --no-install-recommends gstreamer1.0-tools $(ls /source/packages/feeling-wind-gtk_*.deb)' \
    >"$work/install.log" 2>&1 || { tail -n 20 "$work/install.log"; return 1; }
  images run --volume "$work/source:/source:ro" "$container" /source/tests/installed-package.sh
}

promise "the base image is there" base_is_there
promise "the image builds" built
promise "it authors a film" authored
promise "its package serves users" serves_users
images rm --all >/dev/null
