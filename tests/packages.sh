# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # shared with the scripts that source it
# The packages that the tests take from Debian, 12 and 13 alike, beside those of pipelines/shared/packages.sh. To be sourced
# after pipelines/shared/common.sh.

source "$root/pipelines/shared/packages.sh"

# To build and run the tests.
test_packages=(
  libgtest-dev
  libbenchmark-dev
  libumockdev-dev # a mocked USB bus
  umockdev        # umockdev-wrapper
  dbus-daemon     # a bus of a test
  libopencv-calib3d-dev # the benchmark of the motion models compares with it
  clang-format
  shellcheck
  spin # the model of the guardian's protocol
  afl++ # tests/fuzz/coverage.sh
  xvfb
  xauth # xvfb-run needs it
  xdotool
  openbox # full screen under a window manager
  weston  # the program under Wayland
  gir1.2-gst-rtsp-server-1.0 gstreamer1.0-rtsp # a server of rtsp
  pulseaudio # a sound server without a sound card
  at-spi2-core gir1.2-atspi-2.0 # what a screen reader finds in the program
  gir1.2-gtk-3.0 # a window from which a film is dragged
  appstream # appstreamcli checks what software centres read of the program
  gir1.2-gst-plugins-base-1.0 # appsink and regions of interest in Python
  python3-numpy      # motion fields as arrays (docs/python.md)
  mkdocs-material # the pages as a site (mkdocs.yml)
  python3-matplotlib # the plot of docs/python.md
  ffmpeg # remuxes a recording; moving-picture.sh
  mkvtoolnix # remuxes a recording
  parallel # runs pipelines/batch/parallel.sh
  curl # asks the server of a packaged film
  libopencv-imgcodecs-dev # JPEG in the stability suite, frames of the lab
  libjson-glib-dev        # the lab
  node-typescript # compiles the types of the player
  nodejs # the decoder of the player (pipelines/web) against the C++ one
)

# The sanitizers and clang-tidy: each four times as fast as in the default version of Debian 12, and RealtimeSanitizer.
clang_packages=(
  clang-22 libclang-rt-22-dev llvm-22 # with the names in reports, by which suppressions go
  clang-tidy-22
)

# The tests of the player in a browser. npm fetches hls.js and puppeteer-core, which are no Debian packages.
browser_packages=(
  chromium
  firefox-esr
)

# A server of a packaged film. Debian starts it on port 80, and cannot configure it without IPv6: only for --all, which
# can do without it.
server_packages=(
  nginx-light
)

# Engines for batches (pipelines/batch). They bring much with them: only for --all, which can do without them.
engine_packages=(
  snakemake
  slurm-wlm
  buildah # tests/container.sh
)

# npm comes with a nodejs that is not Debian's, and Debian's npm cannot be installed beside one.
install_npm() {
  command -v npm >/dev/null || install_packages npm
}

# To build the Debian package and look at it.
package_packages=(
  build-essential
  debhelper
  help2man # the manual pages
  lintian
)

# The tests on the other Debian (tests/other-debian.sh).
chroot_packages=(
  debootstrap
  iproute2 # a network for tests that is this machine alone
)

# The tests in a virtual machine (tests/hil).
vm_packages=(
  qemu-system-x86
  busybox-static
  cpio
  kmod   # depmod, modprobe
  usbip
  usbutils # lsusb
  v4l-utils # v4l2-ctl
)

# Optional for the lab.
lab_packages=(
  libopencv-contrib-dev # the peer RLOF
  libavcodec-dev libavutil-dev # the motion vectors of H.264 as a peer
)

# The referees of --all (tests/referees), which can do without them.
referee_packages=(
  qemu-user # processors of other generations
  mpv vlc-bin vlc-plugin-base # players
)
