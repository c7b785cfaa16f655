# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the scripts that source it
# What the scripts of this folder share. To be sourced, not run.
set -euo pipefail

# Numbers are written with a point whatever the language of the user.
export LC_ALL=C.UTF-8

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Where the plugins are built. FEELING_WIND_BUILD names another, finished build to use as it is.
build=${FEELING_WIND_BUILD:-$root/build}

# One sentence on stderr that says what is wrong and what to do about it, and a nonzero exit.
fail() {
  echo "${0##*/}: $*" >&2
  exit 1
}

# The comment at the top of the running script is its help.
show_help() {
  sed -n '3,/^[^#]/ s/^# \{0,1\}//p' "$0"
}

# Reads `[--help] [INPUT] [-- OPTION=VALUE...]` into $input and $sink_options.
read_arguments() {
  input=''
  sink_options=()
  while [ $# -gt 0 ]; do
    case $1 in
    --help | -h)
      show_help
      exit
      ;;
    --)
      shift
      sink_options=("$@")
      return
      ;;
    -*) fail "unknown option '$1'; see --help" ;;
    *)
      [ -z "$input" ] || fail "one input only; options of hapticsink come after --, see --help"
      input=$1
      shift
      ;;
    esac
  done
}

# `quoted TEXT` is TEXT as a value in a gst-launch line, whatever characters it holds.
quoted() {
  local text=${1//\\/\\\\}
  if [[ $1 =~ ^[[:alnum:]_.,:/-]+$ ]]; then
    printf '%s' "$1"
  else
    printf '"%s"' "${text//\"/\\\"}"
  fi
}

need_file() {
  [ -n "$1" ] || fail "which video file? See --help"
  [ -e "$1" ] || fail "there is no file '$1'"
  [ ! -d "$1" ] || fail "'$1' is a folder, not a video file"
  [ -r "$1" ] || fail "the file '$1' may not be read by this user"
}

need_camera() {
  local found
  if [ ! -e "$1" ]; then
    found=$(echo /dev/video*)
    [ "$found" != '/dev/video*' ] || found=none
    fail "there is no camera '$1' (cameras here: $found)"
  fi
  [ -c "$1" ] || fail "'$1' is not a camera"
  if [ ! -r "$1" ] || [ ! -w "$1" ]; then
    fail "the camera '$1' may not be used by this user; as root run: usermod -aG video $(id -un)"
  fi
}

has_display() {
  [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]
}

need_display() {
  has_display || fail "there is no display for the window (DISPLAY is not set)"
}

# Raw or Motion-JPEG pictures of a camera. Cameras offer their largest pictures at a few pictures a
# second; motion wants more. The leaky queue keeps the tracker at the newest picture.
camera_pictures=(
  capsfilter 'caps="video/x-raw,framerate=[15/1,120/1];image/jpeg,framerate=[15/1,120/1]"'
  ! queue leaky=downstream max-size-buffers=1 ! decodebin ! videoconvert
)

# Parts of a gst-launch line between roitracker and velocityavg that show the picture in a window, the first
# with what is measured and felt.
# Each branch of the tee needs a queue of its own, otherwise the pipeline never starts.
window_branch=(tee name=t t. ! queue ! videoconvert ! hapticoverlay ! autovideosink t. ! queue !)

# Of a file, which is read as fast as the window takes it: longer queues would let the tracker run ahead
# of what is seen, and what the hand points at would be felt a second later.
file_window_branch=(
  tee name=t t. ! queue max-size-buffers=1 ! videoconvert ! autovideosink
  t. ! queue max-size-buffers=1 !
)

# Configures (the first time) and builds the plugins in $build. What the tools say goes to a log.
build_plugins() {
  local log=$build/build.log
  mkdir -p "$build" || fail "the folder '$build' cannot be made"
  if [ ! -f "$build/build.ninja" ]; then
    echo "Building the plugins in $build (a minute or two, once) ..."
    rm -rf "$build/meson-private" "$build/meson-info" # of a setup that was broken off
    meson setup "$build" "$root" --buildtype=release -Dvision=enabled -Ddevice=enabled -Dtrack=enabled \
      -Dtests=disabled -Dbenchmarks=disabled >"$log" 2>&1 || build_failed "$log"
  fi
  meson compile -C "$build" >"$log" 2>&1 || build_failed "$log"
}

build_failed() {
  tail -n 20 "$1" >&2
  fail "the build failed (log: $1)"
}

# Makes GStreamer find the elements: those of $build, if there is one, otherwise installed ones. Those named,
# or the three that every other pipeline has, must be there.
use_elements() {
  local element needed=("$@")
  [ ${#needed[@]} -gt 0 ] || needed=(roitracker velocityavg hapticsink)
  if [ -d "$build/gst-plugins" ]; then
    export GST_PLUGIN_PATH=$build/gst-plugins${GST_PLUGIN_PATH:+:$GST_PLUGIN_PATH}
    export GST_REGISTRY=${GST_REGISTRY:-$build/registry.bin}
    export SPIDAR_GEOMETRY_PATH=${SPIDAR_GEOMETRY_PATH:-$root/spidar/geometry}
  fi
  command -v gst-inspect-1.0 >/dev/null ||
    fail "GStreamer's tools are not installed; ./pipelines/demo.sh installs and builds everything"
  for element in "${needed[@]}"; do
    # Without a version gst-inspect asks for GStreamer's own.
    gst-inspect-1.0 --exists --atleast-version=0.1 "$element" ||
      fail "GStreamer does not find the element $element; ./pipelines/demo.sh installs and builds everything"
  done
}

# Shows a command so that it can be pasted into a shell.
show_line() {
  local word
  for word; do
    [[ $word =~ ^[[:alnum:]_./:=,!+-]+$ ]] || word=${word@Q}
    printf '%s ' "$word"
  done
  printf '\n'
}

# Elements of this project that launch() needs; none: the usual three.
elements=()

# Becomes gst-launch-1.0 with this pipeline, after showing it. -e: Ctrl-C ends the stream properly,
# so that the force fades out and the log is complete.
launch() {
  use_elements "${elements[@]}"
  show_line gst-launch-1.0 -e "$@"
  exec gst-launch-1.0 -e "$@"
}

# What comes with the packages gstreamer1.0-plugins-bad and -ugly, which not everybody has.
need_packaged_elements() {
  local element
  for element; do
    gst-inspect-1.0 --exists "$element" ||
      fail "GStreamer does not find the element $element; as root run: apt-get install gstreamer1.0-plugins-bad gstreamer1.0-plugins-ugly"
  done
}

# The program haptic-track, of $build or installed.
haptic_track() {
  local program=$build/gst-plugins/track/tools/haptic-track
  [ -x "$program" ] || program=haptic-track
  "$program" "$@"
}

# `pictures_of INPUT`: the beginning of a line, in the array $pictures, for a video file or --test-source. A
# file is read at its own speed.
pictures_of() {
  if [ "$1" = --test-source ]; then
    pictures=(videotestsrc is-live=true pattern=checkers-8 horizontal-speed=2
      ! "video/x-raw,width=352,height=288,framerate=30/1")
  else
    need_file "$1"
    pictures=(filesrc "location=$(quoted "$1")" ! decodebin ! videoconvert ! clocksync)
  fi
}

# H.264 without delay: an encoder that looks ahead would hold the haptic branch back.
h264=(videoconvert ! "video/x-raw,format=I420" ! x264enc tune=zerolatency key-int-max=30)
