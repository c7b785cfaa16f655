# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the scripts that source it
# Functions and settings of all scripts in this folder. To be sourced, not run.
set -euo pipefail

# A decimal point in every language.
export LC_ALL=C.UTF-8

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# The build folder. FEELING_WIND_BUILD names a finished build to use unchanged.
build=${FEELING_WIND_BUILD:-$root/build}

# `fail MESSAGE` prints what is wrong and its cure, and ends the script with status 1.
fail() {
  echo "${0##*/}: $*" >&2
  exit 1
}

# Prints the comment at the top of the running script.
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
      [ -z "$input" ] || fail "one input only; write options of hapticsink after --, see --help"
      input=$1
      shift
      ;;
    esac
  done
}

# `quoted TEXT` prints TEXT as a value for a gst-launch line, with any characters in it escaped.
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
  [ -e "$1" ] || fail "there is no file '$1'; check the name"
  [ ! -d "$1" ] || fail "'$1' is a folder, not a video file; give a file in it"
  [ -r "$1" ] || fail "the file '$1' may not be read by this user; run: chmod +r '$1'"
  [ ! -f "$1" ] || [ -s "$1" ] || fail "the file '$1' is empty, not a video; give another"
}

# Prints the first error in a log of gst-launch, or else its last line.
reason() {
  local text
  text=$(sed -n '/^ERROR: from element/,/^Additional debug info/p' "$1" |
    sed '/^Additional debug info/,$d; s/^ERROR: from element [^ ]*: //')
  printf '%s' "${text:-$(tail -n 1 "$1")}"
}

# `decoding INPUT` sets the array $film to the first part of a line, for a video file or a URL: its frames,
# without interlacing and upright as the camera's rotation tag says.
decoding() {
  local source=(filesrc "location=$(quoted "$1")" ! decodebin name=film)
  ! is_url "$1" || source=(uridecodebin "uri=$(quoted "$1")" name=film)
  film=("${source[@]}" ! videoconvert ! deinterlace ! videoflip video-direction=auto)
}

is_url() {
  [[ $1 =~ ^[a-z][a-z0-9+.-]*:// ]]
}

# `need_video INPUT` fails if the file or URL shows no moving frames. Sets $film, and $has_sound to yes or no.
need_video() {
  local log status=0 seconds=30 # a server may be slow
  is_url "$1" || { seconds=15 && need_file "$1"; }
  find_plugins
  decoding "$1"
  log=$(timeout $seconds gst-launch-1.0 -v "${film[@]}" ! fakesink num-buffers=1 2>&1) || status=$?
  has_sound=no
  ! grep -q 'caps = audio/' <<<"$log" || has_sound=yes
  if grep -qE 'typefind.*caps = image/(jpeg|png|bmp|tiff|webp|svg)' <<<"$log"; then
    fail "'$1' is a still picture, and nothing moves in it; give a video"
  elif grep -q 'typefind.*caps = image/gif' <<<"$log"; then
    fail "GStreamer reads no times of frames from a GIF; make a video of it: ffmpeg -i '$1' video.mp4"
  elif [ $status = 124 ]; then
    fail "'$1' is not a video that GStreamer can play: no frame came within $seconds s; try another one"
  elif [ $status != 0 ] && [ $has_sound = yes ] && ! grep -q 'caps = video/' <<<"$log"; then
    fail "'$1' is not a video: it holds sound only; give another"
  elif [ $status != 0 ]; then
    fail "'$1' is not a video that GStreamer can play; try another one ($(reason <(echo "$log")))"
  fi
}

need_camera() {
  local found
  if [ ! -e "$1" ]; then
    found=$(echo /dev/video*)
    [ "$found" != '/dev/video*' ] || found=none
    fail "there is no camera '$1' (cameras here: $found); plug one in, or give another"
  fi
  # 81 (hexadecimal 51) is the device number of every Video4Linux device.
  [ "$(stat -Lc %t "$1")" = 51 ] || fail "'$1' is not a camera; use /dev/videoN"
  if [ ! -r "$1" ] || [ ! -w "$1" ]; then
    fail "the camera '$1' may not be used by this user; as root run: usermod -aG video $(id -un), then log in again"
  fi
}

has_display() {
  [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]
}

need_display() {
  has_display || fail "there is no display for the window; set DISPLAY, or use play-file.sh"
}

# Decodes raw or Motion-JPEG frames of a camera. Cameras offer their largest frames at a few frames a
# second; the tracker needs at least 15. The leaky queue drops all but the newest frame.
camera_frames=(
  capsfilter 'caps="video/x-raw,framerate=[15/1,120/1];image/jpeg,framerate=[15/1,120/1]"'
  ! queue leaky=downstream max-size-buffers=1 ! decodebin ! videoconvert
)

# The part of a gst-launch line between roitracker and velocityavg that shows the video in a window, with
# motion and force drawn over it. Each branch of the tee needs its own queue, otherwise the pipeline
# never starts.
window_branch=(tee name=t t. ! queue ! videoconvert ! hapticoverlay ! autovideosink t. ! queue !)

# The same for a file, without the drawing. A file is read as fast as the window shows it: with longer
# queues the tracker would be ahead of the window, and the hand would feel a pointer move a second late.
file_window_branch=(
  tee name=t t. ! queue max-size-buffers=1 ! videoconvert ! autovideosink
  t. ! queue max-size-buffers=1 !
)

# Configures (the first time) and builds the plugins in $build, with a log in build.log.
build_plugins() {
  local log=$build/build.log
  mkdir -p "$build" || fail "the folder '$build' cannot be made; check the permissions of its parent"
  if [ ! -f "$build/build.ninja" ]; then
    echo "Building the plugins in $build (a minute or two, once) ..."
    rm -rf "$build/meson-private" "$build/meson-info" # left by an interrupted setup
    meson setup "$build" "$root" --buildtype=release -Dvision=enabled -Ddevice=enabled -Dtrack=enabled \
      -Dtests=disabled -Dbenchmarks=disabled >"$log" 2>&1 || build_failed "$log"
  fi
  meson compile -C "$build" >"$log" 2>&1 || build_failed "$log"
}

build_failed() {
  tail -n 20 "$1" >&2
  fail "the build failed; read the log $1"
}

# Lets GStreamer find the elements of $build, or else the installed ones.
find_plugins() {
  if [ -d "$build/gst-plugins" ] && [[ :${GST_PLUGIN_PATH:-}: != *":$build/gst-plugins:"* ]]; then
    export GST_PLUGIN_PATH=$build/gst-plugins${GST_PLUGIN_PATH:+:$GST_PLUGIN_PATH}
    export GST_REGISTRY=${GST_REGISTRY:-$build/registry.bin}
    export SPIDAR_GEOMETRY_PATH=${SPIDAR_GEOMETRY_PATH:-$root/spidar/geometry}
  fi
  command -v gst-inspect-1.0 >/dev/null ||
    fail "GStreamer's tools are not installed; run ./pipelines/demo.sh, which installs and builds everything"
}

# `use_elements [ELEMENT...]` fails if one of the given elements (default: the usual three) is not found.
use_elements() {
  local element needed=("$@")
  [ ${#needed[@]} -gt 0 ] || needed=(roitracker velocityavg hapticsink)
  find_plugins
  for element in "${needed[@]}"; do
    # By default gst-inspect requires GStreamer's own version number.
    gst-inspect-1.0 --exists --atleast-version=0.1 "$element" ||
      fail "GStreamer does not find the element $element; run ./pipelines/demo.sh, which installs and builds everything"
  done
}

# Prints a command, quoted for a shell.
show_line() {
  local word
  for word; do
    [[ $word =~ ^[[:alnum:]_./:=,!+-]+$ ]] || word=${word@Q}
    printf '%s ' "$word"
  done
  printf '\n'
}

# Elements of this project that launch() requires; if empty, the usual three.
elements=()

# Prints the gst-launch-1.0 line and replaces this shell by it. With -e, Ctrl-C ends the stream properly:
# the force fades out and the log is complete.
launch() {
  use_elements "${elements[@]}"
  show_line gst-launch-1.0 -e "$@"
  exec gst-launch-1.0 -e "$@"
}

# Fails if one of the given elements of gstreamer1.0-plugins-bad or -ugly is missing.
need_packaged_elements() {
  local element
  for element; do
    gst-inspect-1.0 --exists "$element" ||
      fail "GStreamer does not find the element $element; as root run: apt-get install gstreamer1.0-plugins-bad gstreamer1.0-plugins-ugly"
  done
}

# Runs haptic-track of $build, or else the installed one.
haptic_track() {
  local program=$build/gst-plugins/track/tools/haptic-track
  [ -x "$program" ] || program=haptic-track
  "$program" "$@"
}

# A live test video that moves to the left at 60 px/s.
test_source=(videotestsrc is-live=true pattern=checkers-8 horizontal-speed=2
  ! "video/x-raw,width=352,height=288,framerate=30/1")

# `frames_of INPUT` sets the array $frames to the first part of a line, for a video file, a URL or
# --test-source. A file is read at its own speed. $has_sound says whether there is sound.
frames_of() {
  case $1 in
  --test-source) frames=("${test_source[@]}") has_sound=no ;;
  -*) fail "unknown option '$1'; see --help" ;;
  *)
    need_video "$1"
    frames=("${film[@]}" ! clocksync)
    ;;
  esac
}

# H.264 without delay: an encoder with look-ahead would delay the haptic branch.
h264=(videoconvert ! "video/x-raw,format=I420" ! x264enc tune=zerolatency key-int-max=30)
