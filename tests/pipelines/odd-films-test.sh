#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Films of odd kinds play, and the force has the direction of the motion that a viewer sees.

source "$(dirname "$0")/support.sh"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"

# `film NAME OPTION...` makes a film from the clip of a motion to the right at 60 px/s.
clip "$work/right.mkv" 352 288 60 2 uniform:60,0
film() {
  local name=$1
  shift
  ffmpeg -v error -y -i "$work/right.mkv" "$@" "$work/$name" </dev/null
}

# `pushes FILE X Y`: at least 300 rows of the log have a force above 0.1 N, and their mean has the direction.
pushes() {
  awk -F, -v "x=$2" -v "y=$3" '
    NR > 1 && $8 * $8 + $9 * $9 > 0.01 { rows++; fx += $8; fy += $9 }
    END {
      print rows + 0 " rows, mean force " fx / (rows + !rows) " " fy / (rows + !rows) " N"
      exit !(rows >= 300 && fx * x + fy * y > 0.97 * sqrt(fx * fx + fy * fy))
    }' "$1"
}

# `plays TEXT NAME [X Y]`: the film plays and pushes into this direction (y up), to the right by default.
plays() {
  local source=$2
  is_url "$source" || source=$work/$source
  promise "$1 plays" timeout 60 "$root/pipelines/play-file.sh" "$source" -- device=sim "log-location=$work/log.csv"
  promise "and pushes as it moves" pushes "$work/log.csv" "${3:-1}" "${4:-0}"
}

h264=(-c:v libx264 -preset veryfast -crf 18 -pix_fmt yuv420p)
film upright.mp4 "${h264[@]}"
# A telephone held upright: the frames lie on their side, and a tag says so.
lay_on_its_side "$work/upright.mp4" "$work/rotated.mp4"
plays "a film of a telephone held upright" rotated.mp4 0 1

film interlaced.mpg -vf tinterlace=interleave_top,fieldorder=tff -c:v mpeg2video -flags +ilme+ildct -q:v 2
plays "an interlaced film" interlaced.mpg
film ten-bit.mkv -c:v libx264 -preset veryfast -crf 18 -pix_fmt yuv422p10le
plays "a film of ten bits" ten-bit.mkv
film anamorphic.mp4 "${h264[@]}" -aspect 16:9
plays "a film whose pixels are not square" anamorphic.mp4
film odd.mkv -vf crop=351:287 -c:v mjpeg -q:v 2
plays "a film with an odd width and height" odd.mkv
film variable.mkv -vf "select=mod(n\,5)-2" -fps_mode vfr "${h264[@]}"
plays "a film with a variable frame rate" variable.mkv
film vp9.webm -c:v libvpx-vp9 -deadline realtime -cpu-used 8 -b:v 2M
plays "a film as the web has it" vp9.webm
head -c $(($(stat -c %s "$work/right.mkv") * 3 / 4)) "$work/right.mkv" >"$work/cut.mkv"
plays "a film that is cut off" cut.mkv

# `serve FOLDER`: a web server that prints its port.
serve() {
  python3 -c 'if True:
    import functools, http.server, sys
    files = functools.partial(http.server.SimpleHTTPRequestHandler, directory=sys.argv[1])
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), files)
    print(server.server_port, flush=True)
    server.serve_forever()' "$1" 2>/dev/null
}
exec {port}< <(serve "$work")
server=$!
trap 'kill "$server" 2>/dev/null; rm -rf "$work"' EXIT
read -r -u "$port" number
plays "a film of a web server" "http://127.0.0.1:$number/vp9.webm"
plays "a film by its file URL" "file://$work/upright.mp4"

film sound.mkv -f lavfi -i "sine=duration=2" -map 0:v -map 1:a -c:v copy -c:a libvorbis
"$root/pipelines/record.sh" "$work/sound.mkv" "$work/recorded.ts" -- device=sim >/dev/null
promise "a recording keeps the sound" grep -q Audio: <(ffmpeg -i "$work/recorded.ts" 2>&1)
plays "a film with a haptic track" recorded.ts
promise "and has the track" grep -q samples <(haptic_track info "$work/recorded.ts")
