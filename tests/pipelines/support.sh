# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034 # its variables are read by the tests that source it
# What the tests of the scripts share: a scratch folder that goes away, clips of known motion, a
# window system, and assertions about the log of hapticsink. To be sourced.
#
# From the environment: FEELING_WIND_BUILD, the build to test; MAKE_CLIP, the program beside this file.

source "$(dirname "${BASH_SOURCE[0]}")/../../pipelines/shared/common.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../../pipelines/shared/packages.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/promise.sh"
use_elements

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# `clip FILE WIDTH HEIGHT FRAMES-PER-SECOND SECONDS SCENE` writes a video of known motion; see
# make-clip.cpp for the scenes. The ending of FILE chooses the container: mkv (Motion JPEG of high
# quality) or mp4 (H.264).
clip() {
  local encoder=(jpegenc quality=95 ! matroskamux)
  [[ $1 != *.mp4 ]] || encoder=(x264enc tune=zerolatency speed-preset=veryfast bitrate=4000 ! h264parse ! mp4mux)
  "$MAKE_CLIP" "$2" "$3" "$4" "$5" "$6" |
    gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 "width=$2" "height=$3" "framerate=$4/1" \
      ! videoconvert ! "${encoder[@]}" ! filesink "location=$1"
}

# `lay_on_its_side INPUT OUTPUT`: the same frames with a rotation of 90 degrees in the container. From its version
# 6.0 on, ffmpeg has an option for this and ignores the tag of the versions before.
lay_on_its_side() {
  ffmpeg -v error -display_rotation 90 -i "$1" -c copy "$2" 2>/dev/null </dev/null ||
    ffmpeg -v error -i "$1" -c copy -metadata:s:v rotate=90 "$2" </dev/null
}

# At least so many pixels of the picture have the colour (hexadecimal, as od prints it).
has_colour() {
  local count
  count=$(gst-launch-1.0 -q filesrc "location=$1" ! pngdec ! videoconvert ! video/x-raw,format=RGB \
    ! fdsink | od -An -v -tx1 -w3 | grep -c "$2") || true
  [ "$count" -ge "$3" ] || { echo "$count pixels"; return 1; }
}

need_window_system() {
  command -v xvfb-run >/dev/null || skip "xvfb-run is not installed (packages xvfb and xauth)"
}

# Runs a command with an X server of its own.
in_window_system() {
  # A display number of its own: the one just given up by the test before may not be free yet.
  # Without -noreset it starts anew when its first client goes, and the next one may come in between.
  xvfb-run -a -n $((100 + RANDOM % 20000)) -s '-screen 0 1024x768x24 -noreset' "$@"
}

# `interrupt_at LOG ROWS CONDITION COMMAND...`: Ctrl-C once so many rows of the log fulfil the condition.
interrupt_at=$root/tests/pipelines/interrupt-at.sh

# `free_ports COUNT`: the first of so many ports in a row that nobody uses, for UDP or TCP. It depends on the process, so
# that two tests at once do not choose the same.
free_ports() {
  local first port used
  used=$(cat /proc/net/{udp,tcp}{,6} 2>/dev/null | awk '{ sub(".*:", "", $2); print $2 }') || true # IPv6 may be off
  for ((first = 20000 + $$ * 20 % 12000; ; first += 20)); do
    for ((port = first; port < first + $1; port++)); do
      ! grep -qx "$(printf %04X "$port")" <<<"$used" || continue 2
    done
    echo "$first"
    return
  done
}

# `in_log FILE CONDITION [VARIABLE=VALUE...]`: the awk condition holds in every row of the log; the
# fields have the names of its header. Shows the first row where it does not. An empty log fails.
in_log() {
  local file=$1 condition=$2 assignments=()
  shift 2
  for assignment; do
    assignments+=(-v "$assignment")
  done
  awk -F, "${assignments[@]}" '
    function abs(x) { return x < 0 ? -x : x }
    NR == 1 {
      if (index($0, "time,x,y,z,vx,vy,spin,fx,fy,fz,tx,ty,tz,confidence,t0,t1,t2,t3,t4,t5,t6,t7") != 1) {
        print "the header is " $0; bad = 1; exit
      }
      columns = NF
      next
    }
    {
      time = $1; x = $2; y = $3; z = $4; fx = $8; fy = $9; fz = $10
      force = sqrt(fx * fx + fy * fy + fz * fz)
      rows++
      if (!('"$condition"')) { print "row " NR ": " $0; bad = 1; exit }
      before = time
    }
    END { if (rows == 0) print "no rows"; exit bad || rows == 0 }' "$file"
}

# `sound_log FILE MAX-FORCE SECONDS`: all numbers are finite, the time never runs backwards and reaches SECONDS,
# force and tensions stay within their limits.
sound_log() {
  ! grep -qiE 'nan|inf' <(tail -n +2 "$1") || { echo "not finite: $(grep -iE -m 1 'nan|inf' "$1")"; return 1; }
  tail -n 1 "$1" | awk -F, -v "seconds=$3" '{ print "ends at " $1 " s"; exit !($1 >= seconds) }' || return 1
  # shellcheck disable=SC2016 # $i is awk's
  in_log "$1" 'NF == columns && time >= before && force <= max * 1.000001 &&
    $15 >= 0 && $16 >= 0 && $17 >= 0 && $18 >= 0 && $19 >= 0 && $20 >= 0 && $21 >= 0 && $22 >= 0 &&
    $15 <= 5 && $16 <= 5 && $17 <= 5 && $18 <= 5 && $19 <= 5 && $20 <= 5 && $21 <= 5 && $22 <= 5' \
    "max=$2"
}

# `force_of VX VY [MAX-FORCE] [ALPHA]`: equation 5 for a velocity in px/s of a frame 352 px wide, y down. Two
# numbers in N, y up.
force_of() {
  awk -v "vx=$1" -v "vy=$2" -v "most=${3:-1}" -v "alpha=${4:-0.01}" 'BEGIN {
    speed = sqrt(vx * vx + vy * vy)
    force = most * 2 / atan2(0, -1) * atan2(alpha * speed, 1)
    print force * vx / speed, -force * vy / speed
  }'
}

# `felt FILE FX FY [MAX-FORCE]`: 500 rows at least have this force, within 2 % of the maximum, and no row a
# larger one or one in another direction. Other rows may have less: the force fades in, and it fades out
# while a frame is late, which depends on what else the machine does.
felt() {
  awk -F, -v "fx=$2" -v "fy=$3" -v "most=${4:-1}" '
    function abs(x) { return x < 0 ? -x : x }
    BEGIN { wanted = sqrt(fx * fx + fy * fy); x = fx / wanted; y = fy / wanted; near = 0.02 * most }
    NR == 1 { next }
    {
      along = $8 * x + $9 * y; across = abs($8 * y - $9 * x)
      if (along < -near || along > wanted + near || across > near) { print "row " NR ": " $0; bad = 1; exit }
      if (along >= wanted - near) right++
    }
    END { print right + 0 " of " NR - 1 " rows have the force"; exit bad || right < 500 }' "$1"
}

# `ends_without_force FILE`: the last row has none.
ends_without_force() {
  tail -n 1 "$1" | awk -F, '{ exit !(NF >= 22 && $8 == 0 && $9 == 0 && $10 == 0) }'
}

# `smooth FILE [FALLS]`: the force changes by no more than slew-rate allows in the time between two rows. A force of touch
# that the hand leaves, or has not paid for, falls faster (docs/force.md#energy): by no more than FALLS (N/s).
smooth() {
  awk -F, -v "falls=${2:-20}" '
    NR == 1 { for (i = 1; i <= NF; i++) if ($i == "mono") mono = i; next }
    NR > 2 {
      step = sqrt(($8 - fx) ^ 2 + ($9 - fy) ^ 2 + ($10 - fz) ^ 2)
      rate = $8 ^ 2 + $9 ^ 2 + $10 ^ 2 < fx ^ 2 + fy ^ 2 + fz ^ 2 ? falls : 20
      if (step > rate * ($mono - before) * 1.05 + 0.0005) { print "row " NR ": " step " N"; bad = 1; exit }
    }
    { before = $mono; fx = $8; fy = $9; fz = $10 }
    END { exit bad || NR < 1000 }' "$1"
}

# `samples_of SCRIPT ARGUMENT...`: the script plays to its end, though not in real time, and $work/samples gets what the
# same line measures: a motion sample a line, as docs/formats/text-line.md has it.
samples_of() {
  local line said=$work/said-by-script
  "$root/pipelines/$1" "${@:2}" -- device=sim sync=false >"$said" 2>&1 || { cat "$said"; return 1; }
  line=$(grep '^gst-launch-1.0 .* hapticsink device=sim sync=false' "$said") || { cat "$said"; return 1; }
  eval "${line/hapticsink device=sim sync=false/hapticconvert ! text/x-raw ! filesink location=$work/track}" >/dev/null || return 1
  sed 's/hv1 point/\n&/g' "$work/track" | sed 1d >"$work/samples"
}

# `measured CONDITION`: in $work/samples at least 20 samples were measured, and the awk condition on vx and vy, which
# are in px/s, holds in each of them.
measured() {
  awk '{
      for (i = 3; i <= NF; i++) { split($i, pair, "="); value[pair[1]] = pair[2] }
      if (value["conf"] == 0) next
      vx = value["vx"]; vy = value["vy"]; rows++
      if (!('"$1"')) { print "line " NR ": " $0; bad = 1; exit }
    }
    END { print rows + 0 " of " NR " samples were measured"; exit bad || rows < 20 }' "$work/samples"
}

# `send_through RELAY PORT VIDEO RECEIVER...`: sends the video to the port of a relay, whose process ends with it,
# while the command receives. What they say is in $work/sender and $work/receiver, and none of it may be a warning.
send_through() {
  local relay=$1 port=$2 video=$3 receiver status=0
  shift 3
  "$@" >"$work/receiver" 2>&1 &
  receiver=$!
  until grep -q PLAYING "$work/receiver"; do
    kill -0 "$receiver" 2>/dev/null || { cat "$work/receiver"; return 1; }
    sleep 0.05
  done
  "$root/pipelines/send.sh" --port "$port" "$video" >"$work/sender" 2>&1 || status=1
  kill -INT "$receiver"
  wait "$receiver" || status=1
  kill "$relay"
  wait "$relay" || true
  ! grep -E '^(WARNING|ERROR)' "$work/receiver" "$work/sender" || status=1
  return "$status"
}
