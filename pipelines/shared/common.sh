# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the scripts that source it
# Functions and settings of all scripts in this folder. To be sourced, not run.
set -euo pipefail

# A decimal point in every language.
export LC_ALL=C.UTF-8

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

# The build folder. FEELING_WIND_BUILD names a finished build to use unchanged.
build=${FEELING_WIND_BUILD:-$root/build}

# Where films stay that the scripts draw or fetch, and how to get what is missing. An installed copy of the scripts has no
# sources: it builds nothing, and its folder belongs to the system.
kept=$root/build-data get_it="run ./pipelines/demo.sh, which installs and builds everything"
in_checkout() {
  [ -f "$root/meson.build" ]
}
if ! in_checkout; then
  kept=${XDG_CACHE_HOME:-$HOME/.cache}/feeling-wind
  get_it="install the package feeling-wind again"
fi

# `fail MESSAGE` prints what is wrong and its cure, and ends the script with status 1.
fail() {
  echo "${0##*/}: $*" >&2
  exit 1
}

# Prints the comment at the top of the running script.
show_help() {
  sed -n '3,/^[^#]/ s/^# \{0,1\}//p' "$0"
}

# `read_options 'OPTION...' ARGUMENT...` reads the arguments of a script. `name=` is an option --name VALUE, whose value
# goes into $name; `name` is an option --name, which sets $name to yes (a - in it becomes _); `--name` counts as an
# input. $inputs are what is no option. If there is a word `--`, what follows it in the arguments goes to $sink_options.
read_options() {
  local known=" $1 " name
  inputs=() sink_options=()
  while shift && [ $# -gt 0 ]; do
    name=${1#--}
    case $1 in
    --help | -h) show_help && exit ;;
    esac
    if [ "$1" = -- ] && [[ $known = *' -- '* ]]; then
      sink_options=("${@:2}")
      return
    elif [[ $1 != -* || $known = *" $1 "* ]]; then
      inputs+=("$1")
    elif [[ $known = *" $name "* ]]; then
      printf -v "${name//-/_}" yes
    elif [[ $known = *" $name= "* ]]; then
      [ -n "${2:-}" ] || fail "$1 needs a value; see --help"
      printf -v "${name//-/_}" %s "$2"
      shift
    else
      fail "unknown option '$1'; see --help"
    fi
  done
}

# Reads `[--help] [INPUT] [-- OPTION=VALUE...]` into $input and $sink_options.
read_arguments() {
  read_options -- "$@"
  [ ${#inputs[@]} -le 1 ] || fail "there is more than one input; give one, and write options of hapticsink after --, see --help"
  input=${inputs[0]:-}
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
  [ -n "$1" ] || fail "there is no video; name a file, see --help"
  [ -e "$1" ] || fail "there is no file '$1'; check the name"
  [ ! -d "$1" ] || fail "'$1' is a folder, not a video file; give a file in it"
  [ -r "$1" ] || fail "the file '$1' may not be read by this user; run: chmod +r '$1'"
  [ ! -f "$1" ] || [ -s "$1" ] || fail "the file '$1' is empty, not a video; give another"
}

# Reads a log of gst-launch and prints its first error, or else its last line.
reason() {
  local log text
  log=$(cat)
  text=$(sed -n '/^ERROR: from element/,/^Additional debug info/p' <<<"$log" |
    sed '/^Additional debug info/,$d; s/^ERROR: from element [^ ]*: //')
  printf '%s' "${text:-$(tail -n 1 <<<"$log")}"
}

# `decoding INPUT [sound]` sets the array $film to the first part of a line, for a video file or a URL: its frames,
# without interlacing and upright as the camera's rotation tag says. With `sound`, film. is the sound.
decoding() {
  # Without these properties, decodebin of GStreamer 1.22 sometimes never starts when a film has a stream that
  # nothing is linked to.
  local streams=('caps="video/x-raw(ANY)'"${2:+;audio/x-raw(ANY)}\"" expose-all-streams=false name=film)
  film=(filesrc "location=$(quoted "$1")" ! decodebin "${streams[@]}")
  ! is_url "$1" || film=(uridecodebin "uri=$(quoted "$1")" "${streams[@]}")
  film+=(! videoconvert ! deinterlace ! videoflip "video-direction=$(upright_direction "$1")")
}

# `upright_direction INPUT` prints the direction of videoflip. An authored copy of H.264 or H.265 has the rotation in
# each coded picture (display orientation SEI message), which GStreamer 1.22 does not read.
upright_direction() {
  local turn
  if [ -f "$1" ]; then
    for turn in '90r x18' '180 x10' '90l x08'; do
      if LC_ALL=C grep -qaP "(\x06|\x4e\x01)\x2f\x03\\${turn#* }\x00(\x09|\x18)\x80" < <(head -c 1048576 "$1"); then
        echo "${turn% *}"
        return
      fi
    done
  fi
  echo auto
}

# `open_content_only INPUT`: what a file says opens nothing. No element of GStreamer that follows a list of files or
# addresses is chosen, unless the user typed the URL of a playlist.
open_content_only() {
  local element path=${1%%[?#]*}
  ! { is_url "$1" && [[ $path != file://* && $path =~ \.(m3u8|mpd)$ ]]; } || return 0
  for element in hlsdemux{,2} dashdemux{,2} mssdemux{,2} sdpdemux; do
    GST_PLUGIN_FEATURE_RANK+=${GST_PLUGIN_FEATURE_RANK:+,}$element:NONE
  done
  export GST_PLUGIN_FEATURE_RANK
}

is_url() {
  [[ $1 =~ ^[a-z][a-z0-9+.-]*:// ]]
}

# `need_input INPUT` fails if it is neither a URL nor a file with something in it.
need_input() {
  is_url "$1" || need_file "$1"
  open_content_only "$1"
}

# `need_video INPUT [sound]` fails if the file or URL shows no moving frames. Sets $film (see decoding), $has_sound
# to yes or no, $film_rate to the frames in a second as a fraction, $film_width to px, and $film_colours to its
# colorimetry; to nothing if unknown.
need_video() {
  local facts missing cause sound='' seconds=15 place=$1
  need_input "$1"
  if is_url "$1"; then
    seconds=30 # a server may be slow
  elif [[ $1 != /* ]]; then
    place=./$1 # with a colon in it, it would be taken for a URL
  fi
  find_plugins
  need_packaged_elements deinterlace videoflip
  facts=$(timeout $((2 * seconds)) gst-discoverer-1.0 -v -t $seconds "$place" 2>&1 | cut -c 1-1000) || true
  has_sound=no
  ! grep -qE '^ *audio #' <<<"$facts" || has_sound=yes sound=${2:-}
  film_width=$(sed -n 's|^ *Width: \([1-9][0-9]*\)$|\1|p' <<<"$facts" | head -n 1)
  film_colours=$(sed -n '/^ *video #/s|.* colorimetry=(string)\([^,]*\).*|\1|p' <<<"$facts" | head -n 1)
  film_rate=$(sed -n 's|^ *Frame rate: \([1-9][0-9]*/[1-9][0-9]*\)$|\1|p' <<<"$facts" | head -n 1)
  # Of the frames; a haptic track has no decoder either.
  missing=$(sed -nE 's/^ \(gstreamer\|1\.0\|[^|]*\|([^|]*)\|(decoder-(video|image)\/|demuxer-).*/\1/p' <<<"$facts" | head -n 1)
  if grep -qE '^ *video\(image\) #' <<<"$facts"; then
    fail "'$1' is a still picture, and nothing moves in it; give a video"
  elif grep -qE '^ *container #0: image/gif' <<<"$facts"; then
    fail "GStreamer reads no times of frames from a GIF; make a video of it: ffmpeg -i '$1' video.mp4"
  elif grep -qE '^ \(gstreamer\|.*\|decoder-application/(x-hls|dash\+xml|vnd\.ms-sstr\+xml|sdp)' <<<"$facts"; then
    fail "'$1' lists other files or addresses, which are not opened; give the video itself"
  elif [ -n "$missing" ]; then
    fail "'$1' needs a part of GStreamer that is not installed ($missing); as root run: apt-get install $element_packages"
  elif [ $has_sound = yes ] && ! grep -qE '^ *video #' <<<"$facts"; then
    fail "'$1' is not a video: it holds sound only; give another"
  elif ! grep -qE '^ *video #' <<<"$facts"; then
    cause=$(sed -n '/^An error was encountered/{n;s/^ *//p;}' <<<"$facts")
    fail "'$1' is not a video that GStreamer can play; try another one (${cause:-no answer came within $seconds s})"
  fi
  decoding "$1" "$sound"
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

# Returns whether there is a display, and says so if there is none.
may_show() {
  has_display || { echo "There is no display: continuing without a window." && return 1; }
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

# The window of a live video. A pipeline plays only once each of its sinks has its first buffer, a live one too: where
# the first frame of a stream is lost, the force would wait for the next that can be decoded. With async=false
# nothing waits for the window. autovideosink hands the property on to whichever sink it chooses.
live_window=(autovideosink name=window)
for sink in xvimage ximage glimage wayland kms; do
  live_window+=("window-actual-sink-$sink::async=false")
done

# The part of a gst-launch line between roitracker and velocityavg that shows the video in a window, with
# motion and force drawn over it. Each branch of the tee needs its own queue, otherwise the pipeline
# never starts.
window_branch=(tee name=t t. ! queue ! videoconvert ! hapticoverlay ! "${live_window[@]}" t. ! queue !)

# `file_window ELEMENT... !`: the same for a file, with these elements instead of the drawing. A file is read
# as fast as the window shows it: with longer queues the tracker would be ahead of the window, and the hand
# would feel a pointer move a second late.
file_window() {
  file_window_branch=(
    tee name=t t. ! queue max-size-buffers=1 ! "$@" autovideosink
    t. ! queue max-size-buffers=1 !
  )
}
file_window videoconvert !

# `forget_interrupted_setup FOLDER`: else Meson would take it for a configured one.
forget_interrupted_setup() {
  [ -f "$1/build.ninja" ] || rm -rf "$1"/meson-{private,info}
}

# Configures (the first time) and builds the plugins in $build, with a log in build.log.
build_plugins() {
  local log=$build/build.log
  mkdir -p "$build" || fail "the folder '$build' cannot be made; check the permissions of its parent"
  if [ ! -f "$build/build.ninja" ]; then
    echo "Building the plugins in $build (a minute or two, once) ..."
    forget_interrupted_setup "$build"
    # Joined sources take half of the time to compile.
    meson setup "$build" "$root" --buildtype=release --unity=on --unity-size=6 -Dvision=enabled -Ddevice=enabled \
      -Dtrack=enabled -Dtests=disabled -Dbenchmarks=disabled >"$log" 2>&1 || build_failed "$log"
  elif [ ! -f "$build/gst-plugins/vision/libgsthapticvision.so" ]; then # it may have been configured before the packages came
    meson setup --reconfigure "$build" -Dvision=enabled -Ddevice=enabled -Dtrack=enabled >"$log" 2>&1 || build_failed "$log"
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
  [ ! -x "$build/spidar/spidar-guardian" ] || export SPIDAR_GUARDIAN=${SPIDAR_GUARDIAN:-$build/spidar/spidar-guardian}
  local tool
  for tool in gst-inspect-1.0 gst-discoverer-1.0; do
    command -v $tool >/dev/null ||
      fail "GStreamer's tool $tool is not installed; as root run: apt-get install gstreamer1.0-tools gstreamer1.0-plugins-base-apps"
  done
}

# `use_elements [ELEMENT...]` fails if one of the given elements (default: the usual three) is not found.
use_elements() {
  local element needed=("$@")
  [ ${#needed[@]} -gt 0 ] || needed=(roitracker velocityavg hapticsink)
  find_plugins
  for element in "${needed[@]}"; do
    # By default gst-inspect requires GStreamer's own version number.
    gst-inspect-1.0 --exists --atleast-version=0.1 "$element" ||
      fail "GStreamer does not find the element $element; $get_it"
  done
}

# `make_output FOLDER` makes it. A log can be written in it; that of the last run stays until then.
make_output() {
  if ! mkdir -p "$1" 2>/dev/null || ! : 2>/dev/null >>"$1/trace.csv"; then
    fail "the folder '$1' cannot be written to; give another with --output"
  fi
}

# `draw_trace FOLDER SCRIPT TITLE` draws the log in it.
draw_trace() {
  local log=$1/trace.csv plot=$1/trace.png
  if [ "$(wc -l <"$log")" -lt 3 ]; then
    rm -f "$plot"
    echo "Files       $log (too short for a plot)"
    return
  fi
  gnuplot -c "$root/pipelines/shared/$2" "$log" "$plot" "$3" || fail "gnuplot could not draw $plot; install gnuplot-nox"
  echo "Files       $log, $plot"
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

# Stands before a command that a script waits for: if the script is killed, the command ends as with Ctrl-C, and leaves no
# force behind.
with_us=(setpriv --pdeathsig INT)

# Prints the gst-launch-1.0 line and replaces this shell by it. With -e, Ctrl-C ends the stream properly:
# the force fades out and the log is complete. $secret stands where the line has @secret@; it is not shown. $launcher
# is launch.py where a pipeline without a secret needs it, too.
launch() {
  local parent=()
  [ "$BASHPID" = $$ ] || parent=("${with_us[@]}") # in a subshell
  use_elements "${elements[@]}"
  show_line gst-launch-1.0 -e "$@"
  if [ -n "${secret:-${launcher:-}}" ]; then
    /usr/bin/python3 -c 'import gi; gi.require_version("Gst", "1.0")' 2>/dev/null ||
      fail "a key, or RIST, needs two more packages; as root run: apt-get install python3-gi gir1.2-gstreamer-1.0"
    [ -z "${secret:-}" ] || export LAUNCH_SECRET=$secret
    exec "${parent[@]}" /usr/bin/python3 "$root/pipelines/shared/launch.py" "$@"
  fi
  exec "${parent[@]}" gst-launch-1.0 -e "$@"
}

# The packages that hold the elements which the scripts need.
element_packages="gstreamer1.0-plugins-good gstreamer1.0-plugins-bad gstreamer1.0-plugins-ugly gstreamer1.0-libav"

# Fails if one of the given elements of these packages is missing.
need_packaged_elements() {
  local element
  for element; do
    gst-inspect-1.0 --exists "$element" ||
      fail "GStreamer does not find the element $element; as root run: apt-get install $element_packages"
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

# `frames_of INPUT [sound]` sets the array $frames to the first part of a line, for a video file, a URL or
# --test-source. A file is read at its own speed. $has_sound says whether there is sound; with `sound` after
# INPUT, film. is that sound.
frames_of() {
  case $1 in
  --test-source) frames=("${test_source[@]}") has_sound=no ;;
  -*) fail "unknown option '$1'; see --help" ;;
  *)
    need_video "$@"
    frames=("${film[@]}" ! clocksync)
    ;;
  esac
}

# H.264 without delay: an encoder with look-ahead would delay the haptic branch.
h264=(videoconvert ! "video/x-raw,format=I420" ! x264enc tune=zerolatency key-int-max=30)
