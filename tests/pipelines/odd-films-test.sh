#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Films of odd kinds play, and what is measured has the direction of the motion that a viewer sees.

source "$(dirname "$0")/support.sh"
command -v ffmpeg >/dev/null || skip "ffmpeg is not installed"

# `film NAME OPTION...` makes a film from the clip of a motion to the right at 60 px/s.
clip "$work/right.mkv" 352 288 60 2 uniform:60,0
film() {
  local name=$1
  shift
  ffmpeg -v error -y -i "$work/right.mkv" "$@" "$work/$name" </dev/null
}

# `plays TEXT NAME [X Y]`: the film plays and moves into this direction (y down), to the right by default.
plays() {
  local source=$2 x=${3:-1} y=${4:-0}
  is_url "$source" || source=$work/$source
  promise "$1 plays" samples_of play-file.sh "$source"
  promise "and moves as it is seen" measured "vx * $x + vy * $y > 0.97 * sqrt(vx ^ 2 + vy ^ 2)"
}

h264=(-c:v libx264 -preset veryfast -crf 18 -pix_fmt yuv420p)
film upright.mp4 "${h264[@]}"
# A telephone held upright: the frames lie on their side, and a tag says so.
lay_on_its_side "$work/upright.mp4" "$work/rotated.mp4"
plays "a film of a telephone held upright" rotated.mp4 0 -1

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
