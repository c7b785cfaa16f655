# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # shared with the scripts that source it
# The packages that this project takes from Debian, 12 and 13 alike, and its films: wind.ts of the
# demonstration, depth.mkv to touch, and tree.avi from a package. To be sourced after common.sh.

# To run the pipelines.
run_packages=(
  gstreamer1.0-tools        # gst-launch-1.0, gst-inspect-1.0
  gstreamer1.0-plugins-base # decodebin, videoconvert, videotestsrc
  gstreamer1.0-plugins-base-apps # gst-discoverer-1.0; gst-device-monitor-1.0 lists the cameras
  gstreamer1.0-plugins-good # avidemux, deinterlace, videoflip, jpegdec, v4l2src, autovideosink, level, progressreport
  gstreamer1.0-plugins-bad  # mpegtsmux, tsdemux, h264parse, y4mdec, audiobuffersplit
  gstreamer1.0-plugins-ugly # x264enc
  gstreamer1.0-libav        # most video codecs, among them the Cinepak of tree.avi
  gstreamer1.0-x            # video windows
  gnuplot-nox               # the plot of a trace
  python3-gi gir1.2-gstreamer-1.0 # launch.py: a pipeline with a key; the example in Python
)

# To build the plugins.
build_packages=(
  g++
  meson
  ninja-build
  pkg-config
  libgstreamer1.0-dev
  libgstreamer-plugins-base1.0-dev
  libopencv-core-dev
  libopencv-imgproc-dev
  libopencv-video-dev
  libeigen3-dev
  libhwy-dev
  libusb-1.0-0-dev
  libcairo2-dev
  libglib2.0-dev # D-Bus: real-time priority, a moment before the machine sleeps
  libevdev-dev # joysticks with force feedback
  nlohmann-json3-dev # plans, MPEG haptics, patterns for telephones
  esbuild # the web player in one file
)

# The program feeling-wind.
view_packages=(
  libgtk-3-dev
  gstreamer1.0-gtk3
  gstreamer1.0-pulseaudio # sound, also through PipeWire
  gstreamer1.0-alsa       # sound without a sound server
  adwaita-icon-theme      # the icons of its buttons
)

# Prints those of the given packages that are not installed, one a line.
missing_packages() {
  local installed package
  installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "$@" 2>/dev/null |
    sed -n 's/^installed //p') || true
  for package; do
    grep -qxF -- "$package" <<<"$installed" || echo "$package"
  done
}

# Runs a command as root.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    return 127
  fi
}

# `quiet_apt_get LOG ARGUMENT...` runs apt-get without questions and appends its output to LOG.
quiet_apt_get() {
  local log=$1
  shift
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -y -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" >>"$log" 2>&1
}

# Installs those of the given packages that are missing, and lists them. Needs no root where none is missing.
install_packages() {
  local missing log
  if ! command -v dpkg-query >/dev/null; then
    echo "This is not a Debian system. Assuming that these are installed: $*"
    return
  fi
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -gt 0 ] || return 0
  if [ "$(id -u)" != 0 ] && ! command -v sudo >/dev/null; then
    fail "packages are missing and there is no sudo; as root run: apt-get install --no-install-recommends ${missing[*]}"
  fi
  log=$(mktemp)
  echo "Installing ${#missing[@]} Debian packages with apt-get: ${missing[*]}"
  if ! quiet_apt_get "$log" update ||
    ! quiet_apt_get "$log" install --no-install-recommends "${missing[@]}"; then
    tail -n 20 "$log" >&2
    fail "apt-get could not install the packages; check the network and read the log $log"
  fi
  rm -f "$log"
}

# Prints the path of the film of the demonstration.
wind_film() {
  drawn_film wind.ts wind-film "a tree in the wind"
}

# Prints the path of the film of touch-depth.sh: balls in a room, with their depth to the right of them.
depth_film() {
  drawn_film depth.mkv depth-film "balls and their depth"
}

# `drawn_film NAME PROGRAM TEXT` prints the path of a film, which the program draws in less time than it plays. It is
# kept until there is a newer program. For $(...) only: its trap is that of the subshell.
drawn_film() {
  local drawn=$kept/$1 program=$build/pipelines/films/$2
  [ -x "$program" ] || program=$(command -v "$2") ||
    fail "$2 is not built; $get_it"
  if [ ! -f "$drawn" ] || [ "$program" -nt "$drawn" ]; then
    mkdir -p "${drawn%/*}" || fail "the folder '${drawn%/*}' cannot be made; check the permissions of its parent"
    find_plugins
    echo "Drawing the film of $3 ..." >&2
    new=$(mktemp "${drawn%.*}.XXXXXX.${drawn##*.}")
    trap 'rm -f "$new" "$new.part"' EXIT
    case $2 in
    wind-film) "$program" "$new" || return ;;
    depth-film) write_depth_film "$program" "$new" 15 || fail "'$drawn' could not be written; make room on the disk" ;;
    esac
    mv "$new" "$drawn"
  fi
  echo "$drawn"
}

# `write_depth_film PROGRAM FILE SECONDS`: of its depth, coding changes a brightness by one step at most.
write_depth_film() {
  "$1" "$3" | gst-launch-1.0 -q fdsrc ! rawvideoparse format=i420 width=1280 height=360 framerate=30/1 \
    ! x264enc pass=quant quantizer=4 speed-preset=veryfast key-int-max=30 ! h264parse ! matroskamux \
    ! filesink "location=$2" >&2
}

# Strength of the demonstration. With the paper's alpha, 0.01, leaves are felt for less than half of the time.
wind_alpha=0.04

# Sets $input to the film of the demonstration, with its strength in $sink_options, unless there is an input.
default_to_wind_film() {
  [ -z "$input" ] || return 0
  input=$(wind_film)
  sink_options=("alpha=$wind_alpha" "${sink_options[@]}")
}

# Prints the path of tree.avi, a tree in the wind.
tree_video() {
  opencv_file tree.avi
}

# `opencv_file NAME` prints the path of an example's data in the Debian package opencv-doc: tree.avi, or aloeL.jpg and
# aloeGT.png, an aloe and its disparity. Where they are not installed (the package takes 274 MB), the package is fetched
# and only these files are extracted.
opencv_file() {
  found_opencv_file "$1" || { fetch_opencv_files >&2 && found_opencv_file "$1"; }
}

found_opencv_file() {
  local file
  for file in "/usr/share/doc/opencv-doc/examples/data/$1" "$kept/$1"; do
    [ ! -f "$file" ] || { echo "$file"; return; }
  done
  return 1
}

fetch_opencv_files() {
  local data=./usr/share/doc/opencv-doc/examples/data
  mkdir -p "$kept" || fail "the folder '$kept' cannot be made; check the permissions of its parent"
  echo "Fetching the Debian package opencv-doc (91 MB, it is not installed) to extract its tree and its aloe ..."
  (
    folder=$(mktemp -d "$kept/fetch.XXXXXX")
    trap 'rm -rf "$folder"' EXIT
    trap exit INT TERM HUP
    if ! download_package opencv-doc "$folder" ||
      ! dpkg-deb --fsys-tarfile "$folder"/opencv-doc_*.deb |
        tar -x -C "$folder" --strip-components=7 $data/{tree.avi,aloeL.jpg,aloeGT.png}; then
      tail -n 5 "$folder/log" >&2
      exit 1
    fi
    mv "$folder"/{tree.avi,aloeL.jpg,aloeGT.png} "$kept"
  ) || fail "the package opencv-doc could not be fetched; check the network, or give a video of your own"
}

# `download_package NAME FOLDER` fetches a package without installing it, with a log in FOLDER/log.
download_package() {
  (cd "$2" && apt-get download "$1" >log 2>&1) && return
  # A fresh system has no list of packages.
  quiet_apt_get "$2/log" update && (cd "$2" && apt-get download "$1" >>log 2>&1)
}
