#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck disable=SC2317 # until_true calls its functions by name
# The window of feeling-wind under real keys and a real mouse, looked at on the screen.
#
# Usage: program-test.sh [more]
#   more  the other scenes: those that wait for a server or for the drawing of a film, errors, and what else takes long

# `color SHOT NAME`: how many pixels of 200x200 have this colour, and their mean row.
color() {
  od -An -v -tu1 -w3 "$1" | awk -v "name=$2" '
    function is() {
      if (name == "green") return $2 > $1 + 60 && $2 > $3 + 20
      return name == "orange" ? $1 > $2 + 50 && $2 > $3 + 50 : $3 > $2 + 30 && $2 > $1 + 30
    }
    is() { n++; rows += int((NR - 1) / 200) }
    END { printf "%d %d\n", n, n ? rows / n : -1 }'
}
# `shows SHOT NAME CONDITION` on n and row.
shows() {
  local n row
  read -r n row < <(color "$1" "$2")
  echo "$1: $n $2 pixels about row $row"
  [ "$n" -ge 0 ] && (($3))
}

# Runs inside the window system: `program-test.sh SCENE PROGRAM VIDEO FOLDER` leaves what the program said and what
# was on the screen in FOLDER.
if [ $# = 4 ]; then
  set -euo pipefail
  scene=$1 program=$2 video=$3 tests=$(dirname "$(readlink -f "$0")")
  cd "$4"
  source "$tests/window-support.sh"

  # `shot_until NAME COLOR CONDITION [LEFT TOP]`: a shot that fulfils the condition on n and row; by default of the
  # video, without the gauge to the right of the pointer.
  shot_until() {
    fulfilled() {
      point
      shot "$1" "${4:-90}" "${5:-90}"
      shows "$1" "$2" "$3" >/dev/null
    }
    until_true fulfilled "$@"
  }
  # To the middle of the left half, again and again: the window takes the size of the video at some time.
  point() {
    xdotool mousemove 279 190
    xdotool mousemove 280 190
  }
  # `differs NAME OTHER LEFT TOP`: a new shot NAME is not like OTHER.
  differs() {
    shot "$1" "$3" "$4"
    ! cmp -s "$1" "$2"
  }
  # `stands NAME LEFT TOP`: a shot NAME, and half a second later another one that is like it.
  stands() {
    shot "$1" "$2" "$3"
    sleep 0.5
    shot "$1-later" "$2" "$3"
    cmp -s "$1" "$1-later"
  }

  # Against the shots without a menu.
  menu_shown() {
    differs with-menu without-menu 0 50 || differs with-menu-right without-menu-right 600 50
  }
  no_menu_shown() {
    ! menu_shown
  }

  # `logged FILE ROWS CONDITION`: so many rows of the log fulfil the awk condition.
  logged() {
    awk -F, -v "rows=$2" 'NR > 1 && NF >= 22 && '"$3"' { n++ } END { exit n < rows }' "$1"
  }

  # Keys and mouse. The video, 352x288 px, is centred below the title.
  steer() {
    start "$video"
    until_true grep -q 'first frame' said
    # What moves up has an arrow up, and a force up.
    shot_until forward orange 'n > 100 && row < 95'
    shot_until forward blue 'n > 50 && row < 95'
    shot_until gauge blue 'n > 50' 297 90
    shot_until strip orange 'n > 100' 390 340
    shot_until strip blue 'n > 100' 390 340
    until_true differs strip-later strip 390 340
    press space paused
    until_true stands paused 90 90
    until_true stands strip-paused 390 340
    press space playing
    press s 'force off'
    shot_until off blue 'n == 0'
    press s 'force on'
    press Escape 'force off'
    press Escape 'force off' # never on
    press s 'force on'
    press space paused # a menu changes the screen now, the film does not
    for menu in F10 ctrl+d ctrl+k; do
      shot without-menu 0 50
      shot without-menu-right 600 50
      xdotool key "$menu"
      until_true menu_shown
      press Escape 'state homed released'
      until_true no_menu_shown
      press s 'force on'
    done
    # The keys belong to the menu.
    xdotool key F10
    until_true menu_shown
    press 'm Up Down Down Down Down Down Return' 'at 0:'
    if grep sound said; then exit 1; fi
    for shown in ctrl+o ctrl+l F1; do
      xdotool key "$shown"
      dialog
      press Escape 'state homed released'
      xdotool windowfocus "$window"
      press s 'force on'
    done
    press space playing
    press r 'at -1 times'
    shot_until backward orange 'n > 100 && row > 105'
    shot_until backward blue 'n > 10 && row > 105' # the model's name covers a part
    press minus 'at -0.5 times'
    press plus 'at -1 times'
    press '--delay 0 r bracketright' 'region of 38 px' # the seek is still on its way
    until_true grep -q 'at 1 times' said
    press bracketleft 'region of 30 px'
    press greater 'strength (alpha) 0.06 s/px'
    press less 'strength (alpha) 0.04 s/px'
    press l 'force law arctan-axis'
    press o 'rotation 90r'
    press space paused
    press d 'deinterlacing always'
    until_true opened 2
    until_true stands another-pipeline 90 90
    press space playing
    open_url "file://$video"
    until_true opened 3
    press o 'rotation 90r' # from upright again
    press m 'sound off'
    press Down 'sound at 90 %'
    press Up 'sound at 100 %'
    press 0 'region of the default size'
    press ctrl+c 'the grip is in the centre'
    press c 'without curves'
    press v 'the film alone'
    press Right 'at 0:'
    press Left 'at 0:'
    press Home 'at 0:00'
    xdotool key q
    ended
    # They are remembered.
    start --test-source
    until_true grep -q 'first frame' said
    press v 'motion and force are drawn'
    press c 'with curves'
    kill -HUP "$process" # as a terminal that is closed
    ended
  }

  # `choose NAME WORDS` types a name into the dialog for it, and presses Return until the program has written this.
  choose() {
    xdotool key ctrl+a
    xdotool type "$1"
    confirmed() {
      xdotool key Return
      for _ in {1..20}; do
        ! grep -q -- "$1" said || return 0
        sleep 0.1
      done
      return 1
    }
    until_true confirmed "$2"
  }
  # Beside the main window; beside the dialog, too.
  dialog_shown() {
    [ "$(xdotool search --onlyvisible --class feeling-wind | wc -l)" -gt "$(wc -l <<<"$windows")" ]
  }
  completions_shown() {
    [ "$(xdotool search --onlyvisible --class feeling-wind | wc -l)" -gt $(($(wc -l <<<"$windows") + 1)) ]
  }
  # The list of completions takes Return for itself, so Escape closes it first; if it has just gone by itself, Escape
  # closes the dialog.
  refused() {
    ! grep -q 'There is a file .*taken.mkv. Choose another name' said || return 0
    if ! dialog_shown; then
      xdotool windowfocus "$window" key ctrl+r
      dialog
      xdotool key ctrl+a
      xdotool type "$PWD/taken"
      sleep 1 # until the list is shown
    fi
    ! completions_shown || xdotool key Escape
    sleep 0.2
    ! dialog_shown || xdotool key Return
    sleep 0.2
    return 1
  }
  # A recording has film and track; seeking ends it.
  record() {
    # Two, between which the dialog cannot choose: as long as it has seen one of them only, it completes the name.
    touch taken.mkv taken2.mkv
    start "$video"
    until_true grep -q 'first frame' said
    xdotool key ctrl+r
    dialog
    choose "$PWD/recorded.$1" 'recording into'
    xdotool windowfocus "$window"
    sleep 1 # of film
    press Home 'Recorded into'
    until_true refused
    xdotool windowfocus "$window" key q
    ended
  }
  record_matroska() {
    record mkv
  }
  record_transport_stream() {
    record ts
  }

  # Closing the window while it records: the force goes off at once, and the file is completed.
  closing() {
    start --sink "log-location=$PWD/log.csv" "$video"
    until_true grep -q 'state armed' said
    xdotool key ctrl+r
    dialog
    choose "$PWD/closed.mkv" 'recording into'
    xdotool windowfocus "$window"
    sleep 1 # of film
    xdotool key q
    ended
    grep -q 'Recorded into' said
  }

  # The scripted hand of the simulated device points, as a real one does. A force that may not change is cut.
  scripted() {
    start --sink device=sim --sink sim-hand=hold:0.5,0,0 --sink slew-rate=0.1 \
      --sink "log-location=$PWD/scripted.csv" "$video"
    # shellcheck disable=SC2016 # $6 is awk's: vy
    until_true logged scripted.csv 100 '$6 > 80'
    until_true grep -qx 'limited by the slew rate' said
    press d 'deinterlacing always'
    until_true test -s scripted-2.csv
    xdotool windowfocus "$window" key q
    ended
  }

  # What is pressed on, or latched by h, is held; what ends that is said, and ends the latch, too.
  holding() {
    start "$video"
    until_true grep -q 'first frame' said
    shot_until free orange 'n > 100 && row < 95'
    # `says WORDS COMMAND...`: the program writes these words once more.
    says() {
      before=$(grep -cx "$1" said) || true
      "${@:2}"
      once_more() { [ "$(grep -cx "$1" said)" -gt "$before" ]; }
      until_true once_more "$1"
    }
    says 'hold held' xdotool mousedown 1
    says 'hold none' xdotool mouseup 1
    press Home 'at 0:00'
    point
    says 'hold held' xdotool key h
    # The thing in the left half moves up, wherever the mouse goes.
    xdotool mousemove 450 190
    shot green 90 90
    shows green green 'n > 50'
    press h 'let go'
    press Home 'at 0:00'
    point
    # It leaves the frame. Then h holds nothing.
    says 'hold lost' xdotool key h
    # A seek loses what is held, and so does another film.
    press Home 'at 0:00'
    point
    says 'hold held' xdotool key h
    says 'hold lost' xdotool key Home
    press h 'held until'
    open_url "file://$PWD/wall.mkv"
    until_true opened 2
    says 'hold nothing to hold' xdotool key h
    press h 'held until'
    xdotool key q
    ended
    # The button of a hand that points.
    echo 0,-0.5,0,0,1 >hand.csv
    start --sink "sim-hand=file:$PWD/hand.csv" "$video"
    until_true grep -qx 'hold held' said
    xdotool windowfocus "$window" key q
    ended
    # A law of the command line is not remembered.
    start --sink force-law=drag "$video"
    until_true grep -q 'first frame' said
    xdotool windowfocus "$window" key q
    ended
    if grep law=drag "$XDG_CONFIG_HOME"/feeling-wind/*; then exit 1; fi
  }

  # An array vibrates with the film and is drawn, not while the force is off. Without its sound device the film goes on.
  array() {
    for sink in 'audio/x-raw,channels=2' 'identity error-after=100'; do
      start --array ring-8 --array-sink "$sink ! fakesink sync=true" "$video"
      until_true grep -q 'The film goes on without the array' said
      until_true grep -q 'first frame' said
      xdotool key q
      ended
      cat said >>said-of-array
    done
    start --array coils-2 --array-sink 'fakesink sync=true' "$video"
    until_true grep -q 'first frame' said
    shot_until vibrating blue 'n > 300' 525 150
    press s 'force off'
    shot_until resting blue 'n > 10 && n < 100' 525 150
    press d 'deinterlacing always' # another pipeline
    until_true opened 2
    sleep 1 # in which it could vibrate
    shot still 525 150
    shows still blue 'n > 10 && n < 100'
    press s 'force on'
    shot_until vibrating blue 'n > 300' 525 150
    press Right 'at 0:'
    shot_until sought blue 'n > 300' 525 150
    press r 'at -1 times'
    shot_until reversed blue 'n > 300' 525 150
    xdotool key q
    ended
  }

  # A hand with depth touches the colours of the film.
  touch_colours() {
    printf '%s\n' '[table]' unit=mm by=lightness '[entry-1]' colour=#000000 height=4 stiffness=150 friction=0 >own.ini
    start --touch "$PWD/own.ini" --sink sim-hand=hold:0,0,0 --sink "log-location=$PWD/touch.csv" "$video"
    # Pressed in for a second, with one to spare for a machine that is late at times. By any force: see the promise.
    # shellcheck disable=SC2016 # $42 is awk's: touch
    until_true logged touch.csv 2000 '$42 == 1'
    xdotool windowfocus "$window" key q
    ended
    start --touch nothing.ini "$video"
    until_true grep -q 'nothing.ini' said
    cp said said-of-touch
    xdotool key q
    ended
  }

  # A device of a person has no force until that person asks for it. One that cannot be opened is replaced.
  devices() {
    start --device auto "$video"
    until_true grep -q 'state homed released' said
    until_true grep -q 'first frame' said
    if grep -qE 'state (armed|held)' said; then exit 1; fi
    # Nobody holds a device that is plugged in.
    if grep -q 'a simulated one takes its place' said; then
      press s 'force on'
      until_true grep -qE 'state (armed|held)' said # held where nothing is measured
    fi
    xdotool key q
    ended
    start --device evdev:/dev/null "$video"
    until_true grep -q 'is not an input device.*goes on with a simulated device' said
    until_true grep -q 'first frame' said
    xdotool key q
    ended
  }

  # The film of the demonstration is drawn once at a time, and does not replace a film that plays meanwhile.
  demonstration() {
    # shellcheck disable=SC2016 # $1 is that of the script
    printf '#!/bin/sh\necho drawing >>drawings\nuntil [ -e enough ]; do sleep 0.1; done\ncp "%s" "$1"\n' "$video" >wind-film
    chmod +x wind-film
    PATH=$PWD:$PATH start
    play_demonstration() {
      until_true stands without-menu 0 50
      until_true stands without-menu-right 600 50
      xdotool key F10
      until_true menu_shown
      press 'Down Down Return' "$1"
    }
    play_demonstration 'Drawing the film'
    play_demonstration 'wind-film draws the film still'
    open_url "file://$video"
    until_true grep -q 'first frame' said
    touch enough
    until_true grep -q 'is drawn; the menu plays it' said
    [ "$(wc -l <drawings)" = 1 ]
    kill -INT "$process"
    ended
  }

  # A server that accepts and says nothing.
  stall() {
    python3 -c '
import socket, time
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
time.sleep(120)' >port &
    server=$!
    until_true test -s port
    start "http://127.0.0.1:$(<port)/film.mp4"
    until_true grep -q 'Nothing has come from .* for 10 s' said
    open_url "file://$video"
    until_true grep -q 'first frame' said
    kill -INT "$process"
    ended
    kill "$server"
  }

  # What a screen reader finds: every control has a name. Then a film is dropped on the window.
  names() {
    start
    named() { "$tests/accessible-names.py" >names 2>&1; }
    until_true named
    "$tests/drag-source.py" "file://$video" &
    drag=$!
    source_window=$(timeout 60 xdotool search --sync --onlyvisible --name '^drag source$' | tail -n 1)
    xdotool windowmove "$source_window" 850 50
    dropped() {
      xdotool mousemove 900 100 mousedown 1 mousemove 890 120 sleep 0.2 mousemove 500 300 sleep 0.2 \
        mousemove 400 200 sleep 0.2 mousemove 398 200 sleep 0.2 mouseup 1
      sleep 1
      grep -q 'first frame' said
    }
    until_true dropped
    kill "$drag"
    kill -INT "$process"
    ended
  }

  # A server that sends whole files only, and a film with its index at the end.
  whole_file() {
    timeout 120 python3 -c '
import http.server
server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), http.server.SimpleHTTPRequestHandler)
print(server.server_address[1], flush=True)
server.serve_forever()' >port-of-files 2>requests &
    server=$!
    until_true test -s port-of-files
    start "http://127.0.0.1:$(<port-of-files)/index-at-end.mp4"
    until_true grep -q 'a server that does not send parts of a file' said
    open_url "file://$video"
    until_true grep -q 'first frame' said
    kill -INT "$process"
    ended
    kill "$server"
  }

  # Each error is a sentence, and after it another film plays.
  errors() {
    start "$video.missing"
    until_true grep -q 'There is no file' said
    open_url "file://$PWD/sound.wav"
    until_true grep -q 'holds sound only' said
    open_url "file://$PWD"
    until_true grep -q 'is a folder' said
    open_url "file://$PWD/still.png"
    until_true grep -q 'is a still picture' said
    open_url "file://$PWD/none.y4m"
    until_true grep -q 'none.y4m” holds no frames' said
    open_url "file://$0"
    until_true grep -q 'is not a film that can be played' said
    open_url 'http://127.0.0.1:9/film.mp4'
    until_true grep -q 'cannot be reached' said
    open_url 'localhost:8000/film.mp4'
    until_true grep -q 'localhost:8000/film.mp4” is neither a file nor a URL' said
    open_url 'file:///x%zz'
    until_true grep -q 'x%zz” is neither a file nor a URL' said
    open_url /dev/video77
    until_true grep -q 'There is no camera' said
    open_url "file://$video"
    until_true grep -q 'first frame' said
    kill -TERM "$process"
    ended
    cp "$video" with:colon.mkv
    for film in with:colon.mkv wide.mkv; do
      start "$film"
      until_true grep -q 'first frame' said
      kill -TERM "$process"
      ended
    done
  }

  "$scene"
  exit
fi

source "$(dirname "$0")/support.sh"
[ -x "$build/pipelines/feeling-wind/feeling-wind" ] || skip "feeling-wind is not built (package libgtk-3-dev)"
export NO_AT_BRIDGE=1 # nobody has started an accessibility bus
export GSETTINGS_BACKEND=memory # nor a bus of a session
export XDG_CONFIG_HOME=$work/config XDG_CACHE_HOME=$work/cache

program=$build/pipelines/feeling-wind/feeling-wind
need_window_system
command -v xdotool >/dev/null || skip "xdotool is not installed"
gst-inspect-1.0 --exists gtksink || skip "gtksink is not installed (package gstreamer1.0-gtk3)"

clip "$work/clip.mkv" 352 288 30 20 halves:0,-100,0,100

# The same with a second of sound.
gst-launch-1.0 -q filesrc "location=$work/clip.mkv" ! matroskademux ! queue ! matroskamux name=mux ! filesink "location=$work/sound.mkv" \
  audiotestsrc num-buffers=43 ! audioconvert ! vorbisenc ! queue ! mux.

# `recorded FILE WORDS`: what haptic-track says of it.
recorded() {
  haptic_track info "$1" | tee /dev/stderr | grep -q -- "$2"
}
# `unbroken FILE DEMUXER`: no frame between the first and the last is missing.
unbroken() {
  gst-launch-1.0 -v filesrc "location=$1" ! "$2" ! h264parse ! identity silent=false ! fakesink |
    sed -n 's/.*identity0: last-message = chain.* pts: 0:00:\([0-9.]*\),.*/\1/p' | awk '
      NR > 1 && $1 - before > 1.5 / 30 { print "no frame from " before " to " $1 " s"; bad = 1 }
      { before = $1 }
      END { print NR " frames"; exit bad || NR < 15 }'
}
# `records NAME ENDING DEMUXER WORDS`: the scene record_NAME.
records() {
  promise "it records film and track ($1)" in_window_system "$0" "record_$1" "$program" "$work/sound.mkv" "$work"
  promise "the file has every frame" unbroken "$work/recorded.$2" "$3"
  promise "and the track, as $4" recorded "$work/recorded.$2" "$4"
}

if [ "${1:-}" = more ]; then
  records transport_stream ts tsdemux 'KLV in MPEG-TS'
  promise "the film of the demonstration is drawn once, and replaces none that plays" \
    in_window_system "$0" demonstration "$program" "$work/clip.mkv" "$work"
  promise "a URL that stalls is told, and another film can be opened" \
    in_window_system "$0" stall "$program" "$work/clip.mkv" "$work"

  clip "$work/index-at-end.mp4" 352 288 30 20 halves:0,-100,0,100
  promise "a film that its server does not let play is told, not tried for ever" \
    in_window_system "$0" whole_file "$program" "$work/clip.mkv" "$work"

  gst-launch-1.0 -q audiotestsrc num-buffers=20 ! wavenc ! filesink "location=$work/sound.wav"
  gst-launch-1.0 -q videotestsrc num-buffers=1 ! pngenc ! filesink "location=$work/still.png"
  echo 'YUV4MPEG2 W64 H64 F30:1 Ip A1:1 C420jpeg' >"$work/none.y4m"
  # 100 frames a second, of pixels that are not square
  gst-launch-1.0 -q videotestsrc num-buffers=300 \
    ! video/x-raw,width=320,height=240,framerate=100/1,pixel-aspect-ratio=4/3 \
    ! jpegenc ! matroskamux ! filesink "location=$work/wide.mkv"
  promise "an error is a sentence, and another film can be opened" \
    in_window_system "$0" errors "$program" "$work/clip.mkv" "$work"
  cat "$work/said"

  /usr/bin/python3 -c 'import gi
gi.require_version("Atspi", "2.0")
gi.require_version("Gtk", "3.0")' 2>/dev/null || skip "Python has no Atspi and Gtk (packages gir1.2-atspi-2.0, gir1.2-gtk-3.0)"
  unset NO_AT_BRIDGE
  promise "every control has a name for screen readers, and a film can be dropped on the window" \
    in_window_system dbus-run-session -- "$0" names "$program" "$work/clip.mkv" "$work"
  cat "$work/names"
  exit
fi

promise "keys and mouse steer it: arrows and forces follow, the strip scrolls but not while paused, and q ends it well" \
  in_window_system "$0" steer "$root/pipelines/view.sh" "$work/clip.mkv" "$work"
cat "$work/said"
promise "the strip has the curve of the velocity" shows "$work/strip" orange 'n > 100'
promise "the strip has the curve of the force" shows "$work/strip" blue 'n > 100'


records matroska mkv matroskademux 'text lines in Matroska'
promise "closing the window completes a recording" in_window_system "$0" closing "$program" "$work/clip.mkv" "$work"
promise "that file has film and track" recorded "$work/closed.mkv" 'text lines in Matroska'
# 16 in `hold`: released.
# shellcheck disable=SC2016 # $i is awk's
promise "the force was off before the file was completed" awk -F, '
  NR == 1 { for (i = 1; i <= NF; i++) if ($i == "hold") hold = i; next }
  int($hold / 16) % 2 == 1 { rows++ }
  END { print rows + 0 " rows"; exit rows == 0 }' "$work/log.csv"
promise "a scripted hand points, and the window says what limits the force" in_window_system "$0" scripted "$program" "$work/clip.mkv" "$work"
# shellcheck disable=SC2016 # $6 is awk's: vy
promise "it feels the right half, which moves down" \
  awk -F, 'NR > 1 && $6 > 80 { rows++ } END { print rows + 0 " rows"; exit rows < 100 }' "$work/scripted.csv"
gst-launch-1.0 -q videotestsrc num-buffers=600 pattern=solid-color foreground-color=0xff808080 \
  ! video/x-raw,width=352,height=288,framerate=30/1 ! jpegenc ! matroskamux ! filesink "location=$work/wall.mkv"
promise "what is pressed on is held, and let go in every way" in_window_system "$0" holding "$program" "$work/clip.mkv" "$work"
promise "an array vibrates and is drawn while the force is on" in_window_system "$0" array "$program" "$work/clip.mkv" "$work"
promise "what its sound device lacks is said" grep -q 'does not take the 8 channels' "$work/said-of-array"
promise "the colours of a film are touched" in_window_system "$0" touch_colours "$program" "$work/clip.mkv" "$work"
# A late tick makes the surface softer for as long as it is touched (docs/force.md): to 0.2 N·s/m over the longest tick T.
# After one that holds the force, the surface begins anew at the hand, however deep that is.
# shellcheck disable=SC2016 # $4 and $10 are awk's: z and fz
promise "as hard as the table says, or as a late tick lets it be" awk -F, '
  NR == 1 { for (i = 1; i <= NF; i++) { if ($i == "touch") touch = i; if ($i == "mono") mono = i; if ($i == "hold") hold = i }; next }
  { if (NR > 2 && $mono - before > longest) longest = $mono - before; before = $mono }
  $hold != 0 && touched > 0 && as_told < 1000 { anew = 1 }
  $touch == 1 {
    touched++
    depth = 0.004 - $4
    least = longest > 0 && 0.2 / longest < 150 ? 0.2 / longest : 150
    as_told += $10 > 0.95 * least * depth && $10 < 1.05 * 150 * depth
    harder += $10 > 1.05 * 150 * depth
  }
  END {
    printf "%d rows, %d as told, %d harder, longest tick %.1f ms%s\n", touched, as_told, harder, 1000 * longest, anew ? ", held" : ""
    exit harder > 0 || touched < 1000 || (as_told < 1000 && !anew)
  }' "$work/touch.csv"
promise "a table that is not there is told" grep -q 'nothing.ini' "$work/said-of-touch"
promise "a real device begins without force" in_window_system "$0" devices "$program" "$work/clip.mkv" "$work"
