#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# What a file says opens nothing: no address, and no file that the user did not name.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements hapticconvert
for program in ffmpeg python3 strace; do
  command -v "$program" >/dev/null || skip "$program is not installed"
done
strace -o "$work/trace" true 2>/dev/null || skip "no process may be traced here"
export FEELING_WIND_WEB=$root/pipelines/web

# A film that nobody names, by a web server and on the disk.
mkdir "$work/others" "$work/in"
ffmpeg -v error -f lavfi -i testsrc2=size=352x288:rate=30:duration=2 -c:v libx264 -preset veryfast -pix_fmt yuv420p \
  "$work/others/secret.ts"
exec {port}< <(exec python3 -c 'if True:
    import functools, http.server, sys
    files = functools.partial(http.server.SimpleHTTPRequestHandler, directory=sys.argv[1])
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), files)
    print(server.server_port, flush=True)
    server.serve_forever()' "$work/others" 2>"$work/requests")
server=$!
trap 'kill "$server" 2>/dev/null; rm -rf "$work"' EXIT
read -r -u "$port" number

playlist() {
  printf '#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\n%s\n#EXT-X-ENDLIST\n' "$1"
}
playlist "http://127.0.0.1:$number/secret.ts" >"$work/in/network.mp4"
playlist "file://$work/others/secret.ts" >"$work/in/file.mp4"
playlist "file://$work/others/secret.ts" >"$work/in/list.m3u8"
cat >"$work/in/dash.mp4" <<END
<?xml version="1.0"?>
<MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static" mediaPresentationDuration="PT2S" minBufferTime="PT1S"
 profiles="urn:mpeg:dash:profile:isoff-on-demand:2011"><BaseURL>http://127.0.0.1:$number/</BaseURL>
<Period><AdaptationSet mimeType="video/mp4"><Representation id="1" bandwidth="1000" width="352" height="288">
<BaseURL>secret.ts</BaseURL></Representation></AdaptationSet></Period></MPD>
END
cat >"$work/in/session.mp4" <<END
v=0
o=- 0 0 IN IP4 127.0.0.1
s=session
c=IN IP4 127.0.0.1
t=0 0
m=video $number RTP/AVP 96
a=rtpmap:96 H264/90000
END

# `opens_nothing STATUS COMMAND...`: ends with the status in a minute, and neither asks the server nor opens the film.
opens_nothing() {
  local status=0 wanted=$1
  shift
  : >"$work/requests"
  timeout 60 strace -f -qq -e trace=openat,open,connect,bind -o "$work/trace" "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  ! grep -m 3 -E 'secret\.ts|sin6?_port=htons' "$work/trace" || return 1
  [ ! -s "$work/requests" ] && [ "$status" = "$wanted" ]
}
says() { grep -qF -- "$1" "$work/output"; }

for film in "$work"/in/*; do
  name=$(basename "$film")
  for command in "author --output $work/out" "package --output $work/web" info; do
    # shellcheck disable=SC2086 # words
    promise "${command%% *} opens nothing that $name names" opens_nothing 1 "$haptic_track" $command "$film"
  done
  promise "and says that it is no track" says "no haptic track"
done
promise "the reason is one sentence" opens_nothing 1 "$haptic_track" author --output "$work/out" "$work/in/network.mp4"
promise "in words of its own" says "this is a list of other files or addresses, which are not opened"
for name in network file dash; do
  promise "a script opens nothing that $name.mp4 names" opens_nothing 1 \
    "$root/pipelines/play-file.sh" "$work/in/$name.mp4" -- device=sim
  promise "and says why" says "lists other files or addresses"
done
