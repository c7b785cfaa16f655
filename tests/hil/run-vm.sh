#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Runs a command as root in a virtual machine that sees this machine's files, in the current folder,
# and passes on what it prints and its exit status. The machine has a kernel of its own, Debian's,
# with the drivers that need one: USB devices from the network (vhci-hcd), a camera that draws
# itself (vivid), input devices (uinput). What the command writes is forgotten with the machine.
#
# Usage: tests/hil/run-vm.sh [--time-limit SECONDS] COMMAND [ARGUMENT...]
#   --time-limit SECONDS  how long the machine may run; 800 and three times HIL_SECONDS
#
# Example: tests/hil/run-vm.sh sh -c 'modprobe vivid n_devs=1 && ls /dev/video0'
#
# Exit status 77: no virtual machine can run here; a line that begins with SKIPPED says why.
# The kernel's package is fetched once and unpacked in build-data/vm, not installed.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/../../tests/packages.sh"

skip() {
  echo "SKIPPED: $*"
  exit 77
}

limit=$((800 + 3 * ${HIL_SECONDS:-0}))
case ${1:-} in
--help | -h) show_help && exit ;;
--time-limit)
  limit=${2:-}
  [[ $limit =~ ^[1-9][0-9]*$ ]] || fail "--time-limit needs a number of seconds"
  shift 2
  ;;
-*) fail "unknown option '$1'; see --help" ;;
esac
[ $# -gt 0 ] || fail "there is no command; name one, see --help"

[ "$(uname -m)" = x86_64 ] || skip "the virtual machine is for x86_64"
for program in qemu-system-x86_64 busybox cpio depmod; do
  PATH=$PATH:/usr/sbin:/sbin command -v "$program" >/dev/null ||
    skip "$program is not installed (packages ${vm_packages[*]})"
done

# What is taken out of the kernel's package: what the machine needs to see files, and the drivers
# above with what they build on.
module_folders=(
  drivers/virtio
  fs/{9p,fscache,netfs,overlayfs} net/9p
  drivers/usb/{common,core,usbip}
  drivers/media/{cec,common,mc,rc,test-drivers,v4l2-core} drivers/video drivers/input
)
# Those needed before the files can be seen.
first_modules=(virtio_pci 9p 9pnet_virtio overlay)

unpacked=$root/build-data/vm

# Leaves vmlinuz, lib/modules/VERSION and initramfs in $unpacked.
fetch_kernel() {
  local folder name version
  echo "Fetching Debian's kernel (about 70 MB, once) for the virtual machine ..."
  mkdir -p "$root/build-data"
  folder=$(mktemp -d "$root/build-data/fetch.XXXXXX")
  # shellcheck disable=SC2064 # this folder, whatever happens to the variable
  trap "rm -rf '$folder'" EXIT
  # linux-image-amd64 is only a name for the newest one.
  name=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[^ ]*\)$/\1/p' | head -n 1)
  if [ -z "$name" ]; then
    quiet_apt_get "$folder/log" update || true
    name=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[^ ]*\)$/\1/p' | head -n 1)
  fi
  [ -n "$name" ] || skip "apt knows no package linux-image-amd64"
  download_package "$name" "$folder" || skip "the package $name cannot be fetched: $(tail -n 1 "$folder/log")"
  dpkg-deb --fsys-tarfile "$folder/$name"_*.deb >"$folder/tar" || skip "the package $name cannot be unpacked"
  version=${name#linux-image-}
  tar -xf "$folder/tar" -C "$folder" "./boot/vmlinuz-$version" "./lib/modules/$version/modules.order" \
    "./lib/modules/$version/modules.builtin" "./lib/modules/$version/modules.builtin.modinfo" \
    "${module_folders[@]/#/./lib/modules/$version/kernel/}" || skip "the package $name has other contents than expected"
  rm "$folder/tar" "$folder/$name"_*.deb
  mv "$folder/boot/vmlinuz-$version" "$folder/vmlinuz"
  PATH=$PATH:/usr/sbin:/sbin depmod -b "$folder" "$version"
  make_initramfs "$folder" "$version"
  rm -rf "$unpacked"
  mv "$folder" "$unpacked"
}

# `make_initramfs FOLDER VERSION`: busybox, the first modules, and what to do with them.
make_initramfs() {
  local initramfs=$1/initramfs.d module file
  mkdir -p "$initramfs"/{bin,dev,proc,lower,upper,top,lib}
  cp "$(command -v busybox)" "$initramfs/bin/busybox"
  ln -s busybox "$initramfs/bin/sh"
  # In the order of loading, each once.
  for module in "${first_modules[@]}"; do
    PATH=$PATH:/usr/sbin:/sbin modprobe -d "$1" -S "$2" --show-depends "$module"
  done | sed -n 's/^insmod //p' | awk '!seen[$1]++ { print $1 }' >"$1/first"
  while IFS= read -r file; do
    cp "$file" "$initramfs/lib/"
    echo "insmod /lib/${file##*/}"
  done <"$1/first" >"$initramfs/load"
  [ -s "$initramfs/load" ] || skip "the kernel lacks the modules ${first_modules[*]}"
  cat >"$initramfs/init" <<'INIT'
#!/bin/sh
/bin/busybox --install -s /bin
export PATH=/bin
mount -t devtmpfs dev /dev
exec </dev/null >/dev/ttyS0 2>&1
mount -t proc proc /proc
. /load
mount -t 9p -o ro,trans=virtio,version=9p2000.L,msize=524288,cache=loose files /lower
mount -t tmpfs tmpfs /upper
mkdir /upper/files /upper/work
mount -t overlay -o lowerdir=/lower,upperdir=/upper/files,workdir=/upper/work overlay /top
cd /top
mount --move /dev dev
mount --move /proc proc
mount -t sysfs sys sys
mkdir -p lib/modules run dev/shm
mount -t tmpfs tmpfs run
mount -t tmpfs tmpfs dev/shm
parameter() {
  sed -n "s/.* $1=\([^ ]*\).*/\1/p" proc/cmdline
}
mkdir -p "lib/modules/$(uname -r)"
mount --bind ".$(parameter modules)/$(uname -r)" "lib/modules/$(uname -r)"
ip link set lo up
exec chroot . /bin/bash "$(parameter job)"
INIT
  chmod +x "$initramfs/init"
  (cd "$initramfs" && find . | cpio -o -H newc -R 0:0 --quiet | gzip -1) >"$1/initramfs"
  rm -rf "$initramfs"
}

[ -f "$unpacked/initramfs" ] || fetch_kernel

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# What the machine runs once it sees the files. The last thing it says on the second serial port is
# the exit status; without it the machine did not get so far.
{
  for name in FEELING_WIND_BUILD GST_REGISTRY HIL_SECONDS; do
    [ -z "${!name:-}" ] || printf 'export %s=%q\n' "$name" "${!name}"
  done
  printf 'cd %q\n' "$PWD"
  printf 'command=(%s)\n' "${*@Q}"
  cat <<'JOB'
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8
"${command[@]}"
echo $? >/dev/ttyS1
sleep 0.1 # until the serial ports are empty
exec busybox poweroff -f
JOB
} >"$scratch/job"

# shellcheck disable=SC2054 # commas of qemu's
machine=(
  qemu-system-x86_64
  -accel 'tcg,thread=multi' -cpu Nehalem -smp 2 -m 2048
  -nodefaults -no-reboot -display none -monitor none
  -kernel "$unpacked/vmlinuz" -initrd "$unpacked/initramfs"
  -append "quiet console=ttyS0 nokaslr mitigations=off panic=-1 modules=$unpacked/lib/modules job=$scratch/job"
  -virtfs 'local,path=/,mount_tag=files,security_model=none,readonly=on,multidevs=remap'
  -serial stdio -serial "file:$scratch/status"
)
timeout --foreground -k 5 "$limit" "${machine[@]}" </dev/null 2>"$scratch/errors" | sed -u 's/\r$//' || true
status=$(tr -d '\r\n' <"$scratch/status" 2>/dev/null) || true
if [ -z "$status" ]; then
  cat "$scratch/errors" >&2
  fail "the virtual machine ended without a result (time limit $limit s)"
fi
exit "$status"
