#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck disable=SC2317 # until_true calls its functions by name
# Where the films of feeling-wind come from, and where their sound goes: a server of rtsp that stalls and ends, a file
# that is deleted or cut while it plays, a sound server; and what is plugged in while it runs.

# Inside the X server: `program-sources-test.sh SCENE PROGRAM VIDEO FOLDER`.
if [ $# = 4 ]; then
  set -euo pipefail
  scene=$1 program=$2 video=$3 tests=$(dirname "$(readlink -f "$0")")
  cd "$4"
  source "$tests/window-support.sh"

  # `said_again WORDS`: once more than before.
  said_again() {
    [ "$(grep -c -- "$1" said)" -gt "$before" ]
  }
  closed() {
    xdotool windowfocus "$window" key q
    ended
  }

  rtsp() {
    /usr/bin/python3 - >port <<'SERVER' &
import gi
gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer
Gst.init(None)
server = GstRtspServer.RTSPServer(service="0")
factory = GstRtspServer.RTSPMediaFactory(shared=True)
factory.set_launch(
    "( videotestsrc is-live=true pattern=checkers-8 horizontal-speed=2 ! video/x-raw,width=352,height=288,framerate=30/1"
    " ! x264enc tune=zerolatency speed-preset=ultrafast key-int-max=30 ! rtph264pay name=pay0 )")
server.get_mount_points().add_factory("/film", factory)
server.attach(None)
print(server.get_bound_port(), flush=True)
GLib.MainLoop().run()
SERVER
    server=$!
    until_true test -s port
    start "rtsp://127.0.0.1:$(<port)/film"
    until_true grep -q 'first frame' said
    until_true grep -q 'state armed' said
    kill -STOP "$server"
    until_true grep -q 'Nothing has come from .* for 10 s' said
    before=$(grep -c 'state armed' said)
    kill -CONT "$server"
    until_true said_again 'state armed'
    kill -KILL "$server"
    wait "$server" 2>/dev/null || true
    until_true grep -qE '^feeling-wind: .*(cannot be reached|not read any further)' said
    open_url "file://$video"
    until_true opened 2
    closed
  }

  # The program has the file open, and plays it again from its beginning. Only to open it again fails.
  deleted() {
    cp "$video" film.mkv
    start film.mkv
    until_true grep -q 'first frame' said
    rm film.mkv
    before=$(grep -c 'state held ended' said) || true
    until_true said_again 'state held ended'
    before=$(grep -c 'state armed' said)
    until_true said_again 'state armed'
    xdotool key d
    until_true grep -q 'There is no file “film.mkv”' said
    open_url "file://$video"
    until_true opened 2
    closed
  }

  # What is left of it plays, or a sentence is said.
  cut() {
    cp "$video" film.mkv
    start film.mkv
    until_true grep -q 'first frame' said
    truncate -s 20000 film.mkv
    until_true grep -qE 'state held ended|cannot be played' said
    open_url "file://$video"
    until_true opened 2
    closed
  }

  # `loudest CONDITION` on the largest sample of a tenth of a second, of 32767.
  loudest() {
    local most
    most=$(gst-launch-1.0 -q pulsesrc device=out.monitor num-buffers=10 ! audio/x-raw,format=S16LE,channels=1 ! fdsink |
      od -An -v -td2 -w2 | awk '{ x = $1 < 0 ? -$1 : $1; if (x > most) most = x } END { print most + 0 }')
    echo "loudest $most" >>heard
    (($1))
  }
  sound() {
    export PULSE_SERVER=unix:$PWD/sound.socket HOME=$PWD XDG_RUNTIME_DIR=$PWD
    pulseaudio -n --daemonize=no --exit-idle-time=-1 --use-pid-file=no \
      -L 'module-null-sink sink_name=out' -L "module-native-protocol-unix auth-anonymous=1 socket=$PWD/sound.socket" \
      >pulse.log 2>&1 &
    server=$!
    until_true test -S sound.socket
    start sound.mkv
    until_true grep -q 'first frame' said
    until_true loudest 'most > 1000'
    press m 'sound off'
    until_true loudest 'most == 0'
    press m 'sound on'
    until_true loudest 'most > 1000'
    press plus 'at 2 times' # another pitch
    until_true loudest 'most == 0'
    kill "$server"
    until_true grep -q 'The film goes on' said
    until_true opened 2
    closed
  }

  # What is plugged in while the program runs comes into the open menu; what is unplugged goes.
  plugged() {
    export PLUGGED_DEVICES=$PWD/plugged
    : >plugged
    start "$video"
    until_true grep -q 'first frame' said
    listed() {
      "$tests/accessible-names.py" >names 2>&1 || true
      grep -q "'$1'" names
    }
    not_listed() {
      ! listed "$1"
    }
    xdotool key ctrl+k
    until_true listed 'No camera is plugged in'
    echo "camera $PWD/no-camera Camera of the test" >>plugged
    until_true listed 'Camera of the test'
    not_listed 'No camera is plugged in'
    : >plugged
    until_true not_listed 'Camera of the test'
    xdotool key Escape
    xdotool key ctrl+d
    until_true listed 'Simulated, the mouse points'
    echo 'haptic usb:7 SPIDAR-G of the test' >plugged
    until_true listed 'SPIDAR-G of the test'
    : >plugged
    until_true not_listed 'SPIDAR-G of the test'
    xdotool key Escape
    closed
  }

  "$scene"
  exit
fi

source "$(dirname "$0")/support.sh"
program=$build/pipelines/feeling-wind/feeling-wind
[ -x "$program" ] || skip "feeling-wind is not built (package libgtk-3-dev)"
need_window_system
command -v xdotool >/dev/null || skip "xdotool is not installed"
gst-inspect-1.0 --exists gtksink || skip "gtksink is not installed (package gstreamer1.0-gtk3)"
export NO_AT_BRIDGE=1 GSETTINGS_BACKEND=memory XDG_CONFIG_HOME=$work/config XDG_CACHE_HOME=$work/cache

clip "$work/clip.mkv" 352 288 30 4 uniform:60,0
for scene in deleted cut; do
  promise "a file that is $scene while it plays" in_window_system "$0" "$scene" "$program" "$work/clip.mkv" "$work"
done
if /usr/bin/python3 -c 'import gi
gi.require_version("GstRtspServer", "1.0")' 2>/dev/null; then
  promise "a server of rtsp that stalls, and ends" in_window_system "$0" rtsp "$program" "$work/clip.mkv" "$work"
fi
if command -v pulseaudio >/dev/null && gst-inspect-1.0 --exists pulsesink; then
  clip "$work/long.mkv" 352 288 30 20 uniform:60,0
  gst-launch-1.0 -q matroskamux name=m ! filesink "location=$work/sound.mkv" \
    filesrc "location=$work/long.mkv" ! matroskademux ! m. \
    audiotestsrc num-buffers=861 ! audioconvert ! vorbisenc ! m.
  promise "sound is heard at normal speed, and its server may go" \
    in_window_system "$0" sound "$program" "$work/clip.mkv" "$work"
fi
if command -v dbus-run-session >/dev/null && /usr/bin/python3 -c 'import gi
gi.require_version("Atspi", "2.0")' 2>/dev/null; then
  unset NO_AT_BRIDGE
  GST_PLUGIN_PATH=$GST_PLUGIN_PATH:$PLUGGED_DEVICES_PLUGIN promise "the menus follow what is plugged in" \
    in_window_system dbus-run-session -- "$0" plugged "$program" "$work/clip.mkv" "$work"
fi
