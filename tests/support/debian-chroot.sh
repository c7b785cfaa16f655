# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2154
# A chroot of another Debian, whose packages come from the archive that apt uses on this machine, with apt's settings.
# Needs root, debootstrap, and pipelines/shared/common.sh.

# Everything that is mounted or started after this goes away with the script, however it ends.
enter_namespaces() {
  local child
  [ "${CHROOT_NAMESPACES:-}" != yes ] || return 0
  [ "$(id -u)" = 0 ] || skip "a chroot needs root; as root run: $0"
  unshare --mount --pid --net --fork --mount-proc true 2>/dev/null ||
    skip "this machine does not allow namespaces and mounts"
  CHROOT_NAMESPACES=yes \
    unshare --mount --propagation private --pid --fork --kill-child --mount-proc "$0" "$@" &
  child=$!
  trap 'kill -KILL "$child"; exit 130' INT TERM
  wait "$child"
  exit
}

# The archive of Debian that apt uses on this machine.
find_archive() {
  local archives
  # shellcheck disable=SC2016 # for apt
  mapfile -t archives < <(apt-get indextargets --format '$(REPO_URI)' \
    'Created-By: Packages' 'Origin: Debian' 'Label: Debian' 'Component: main')
  archive=${archives[0]:-}
  archive=${archive%/}
}

# Puts the code name of the wanted version into $codename. The archive knows it by an alias that changes with time.
find_codename() {
  local alias
  for alias in stable oldstable oldoldstable; do
    /usr/lib/apt/apt-helper download-file "$archive/dists/$alias/Release" "$work/Release" || continue
    if grep -q "^Version: $version\(\.\|$\)" "$work/Release"; then
      codename=$(sed -n 's/^Codename: //p' "$work/Release")
      return
    fi
  done
  echo "The archive $archive has no Debian $version."
  return 1
}

# The proxy that apt uses for the archive, or nothing.
proxy_of_archive() {
  local scheme=${archive%%:*} host=${archive#*://} key proxy=''
  host=${host%%[:/]*}
  for key in "Acquire::$scheme::Proxy::$host" "Acquire::$scheme::Proxy" "Acquire::http::Proxy"; do
    [ -n "$proxy" ] || eval "$(apt-config shell proxy "$key")"
  done
  [ -n "$proxy" ] ||
    proxy=$(/usr/lib/apt/apt-helper auto-detect-proxy "$archive" | sed -n "s/^Using proxy '\(.*\)' for.*/\1/p")
  [ "$proxy" = DIRECT ] || echo "$proxy"
}

# `copy_settings FOLDER PROXY` gives a chroot the machine's settings of name service, apt and certificates.
copy_settings() {
  local settings=$1/etc/apt/apt.conf.d/90machine file
  cp -L /etc/resolv.conf /etc/hosts "$1/etc/"
  cp -rL --parents /etc/ssl/certs /usr/local/share/ca-certificates "$1/" 2>/dev/null || true
  apt-config dump --no-empty --format '%F "%v";%n' |
    grep '^Acquire::' | grep -viE '^Acquire::(Changelogs|IndexTargets|cdrom)|Proxy-?Auto-?Detect' \
    >"$settings" || true
  [ -z "$2" ] || echo "Acquire::http::Proxy \"$2\";" >>"$settings"
  sed -nE 's/^Acquire::.*::(CaInfo|CaPath|SslCert|SslKey|CrlFile) "(.*)";/\2/Ip' \
    "$settings" | while read -r file; do
    cp -rL --parents "$file" "$1/"
  done
}

# Makes the chroot $chroot of Debian $version, unless it is there; $fresh=yes makes it anew. Needs a folder $work.
make_chroot() {
  local proxy
  [ "$fresh" = no ] || rm -rf --one-file-system "$chroot"
  if [ ! -d "$chroot" ]; then
    find_archive
    if [ -z "$archive" ]; then
      quiet_apt_get "$work/update.log" update || true # a fresh machine has no lists yet
      find_archive
    fi
    [ -n "$archive" ] || { echo "apt's sources name no archive of Debian."; return 1; }
    find_codename || return
    proxy=$(proxy_of_archive)
    rm -rf --one-file-system "$chroot.part"
    env ${proxy:+http_proxy=$proxy https_proxy=$proxy} debootstrap --variant=minbase --force-check-gpg \
      --arch="$(dpkg --print-architecture)" "$codename" "$chroot.part" "$archive" || return
    echo force-unsafe-io >"$chroot.part/etc/dpkg/dpkg.cfg.d/unsafe-io" # twice as fast
    copy_settings "$chroot.part" "$proxy" || return
    mv "$chroot.part" "$chroot"
  fi
  rm -rf --one-file-system "${chroot:?}"/tmp/* "$chroot/tmp/".[!.]*
  mount -t proc proc "$chroot/proc" && mount --rbind /sys "$chroot/sys" && mount --rbind /dev "$chroot/dev"
}

# `copy_tree FOLDER`: the working tree, without what git ignores.
copy_tree() {
  local file
  rm -rf "$1"
  mkdir -p "$1"
  git -C "$root" -c safe.directory="$root" ls-files -z --cached --others --exclude-standard --deduplicate |
    while IFS= read -r -d '' file; do
      [ ! -e "$root/$file" ] || printf '%s\0' "$file"
    done | tar -C "$root" --null --no-recursion -T - -c | tar -C "$1" -x
}
