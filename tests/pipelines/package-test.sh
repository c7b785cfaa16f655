#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track package: what is in the folder, that it can be trusted, and what happens when something goes wrong.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert reliefmap
for command in ffmpeg ffprobe python3; do
  command -v "$command" >/dev/null || skip "$command is not installed"
done

export FEELING_WIND_WEB=$work/web
mkdir "$FEELING_WIND_WEB"
echo '<!DOCTYPE html><script type="module" src="player.js"></script>' >"$FEELING_WIND_WEB/index.html"
echo 'export {};' >"$FEELING_WIND_WEB/player.js"

# `film FILE WIDTH`: 9 s of H.264 whose left half moves up and the right one down, with sound, B-frames, and an IDR frame
# each second.
film() {
  "$MAKE_CLIP" 352 288 25 9 halves:0,-100,0,100 |
    ffmpeg -v error -f rawvideo -pix_fmt gray -s 352x288 -r 25 -i - -f lavfi -i sine=d=9 -shortest -vf "scale=$2:-2" \
      -c:v libx264 -preset veryfast -pix_fmt yuv420p -g 25 -bf 2 -c:a aac "$1"
}
package() { "$haptic_track" package "$@"; }
check() { python3 "$root/tests/pipelines/package-check.py" "$1"; }
# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}

film "$work/wind.mp4" 352
promise "a film is packaged" says 0 "225 fields" package --output "$work/film" "$work/wind.mp4"
promise "its files are what they should be" check "$work/film"
complete() {
  local file
  for file in "$1"/{index.html,player.js,poster.jpg,film.m3u8} "$1"/mp4-*/{head.mp4,00001.mp4,film.m3u8}; do
    [ -s "$file" ] || { echo "$file"; return 1; }
  done
  [ ! -e "$1/.package" ] && [ ! -e "$1/.package.lock" ]
}
promise "nothing is missing, nothing else is left" complete "$work/film"
promise "the poster is a picture" says 0 352,288 ffprobe -v error -show_entries stream=width,height -of csv=p=0 "$work/film/poster.jpg"
promise "as a transport stream too" package --carriage ts --output "$work/ts" "$work/wind.mp4"
promise "which is what it should be" check "$work/ts"

# Segments of 4 s and the rest of 5 s: the last second is too short for one of its own.
lengths() { [ "$(grep -h EXTINF "$1"/*/film.m3u8)" = "$(printf '#EXTINF:4.000000,\n#EXTINF:5.000000,')" ]; }
promise "segments last 2 to 6 s" lengths "$work/film"
# `frames FILE`: of video and sound, decoded.
frames() { ffprobe -v error -count_frames -show_entries stream=codec_name,nb_read_frames -of csv=p=0 "$1" | grep -v klv | sort -u; }
every_segment_decodes() {
  local count=0 segment
  for segment in "$work"/ts/ts-*/0*.ts; do
    ffmpeg -v error -i "$segment" -map 0:v -map 0:a -f null - 2>"$work/errors" </dev/null
    [ ! -s "$work/errors" ] || { cat "$work/errors"; return 1; }
    count=$((count + $(frames "$segment" | sed -n 's/^h264,//p')))
  done
  for segment in "$work"/film/mp4-*/0*.mp4; do
    cat "${segment%/*}/head.mp4" "$segment" >"$work/alone.mp4"
    ffmpeg -v error -i "$work/alone.mp4" -f null - 2>"$work/errors" </dev/null
    [ ! -s "$work/errors" ] || { cat "$work/errors"; return 1; }
    count=$((count + $(frames "$work/alone.mp4" | sed -n 's/^h264,//p')))
  done
  echo "$count frames"
  [ "$count" = 450 ]
}
promise "each segment can be decoded alone" every_segment_decodes
# The fields of a segment alone, decoded: as many as its packets.
fields_of_each() {
  local segment count
  for segment in "$work"/ts/ts-*/0*.ts; do
    count=$(gst-launch-1.0 -v filesrc "location=$segment" ! tsdemux ! meta/x-klv ! hapticconvert ! haptics/x-raw \
      ! identity silent=false ! fakesink 2>&1 | grep -c 'last-message = chain') || return 1
    echo "$count fields"
    [ "$count" = 100 ] || [ "$count" = 125 ] || return 1
  done
}
promise "so can its fields" fields_of_each
# The same values as in the track that was authored, at the times of the frames.
same_values() {
  "$haptic_track" author --output "$work" "$work/wind.mp4" >/dev/null &&
    cat "$work"/ts/ts-*/0*.ts >"$work/joined.ts" &&
    for name in wind.haptic joined; do
      gst-launch-1.0 -q filesrc "location=$work/$name.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! haptics/x-raw \
        ! filesink "location=$work/$name.raw" || return 1
    done
  cmp "$work/wind.haptic.raw" "$work/joined.raw"
}
promise "no value of the track changes" same_values
# Without what is heard before the first frame and after the last one.
same_sound() {
  ffmpeg -v error -i "$work/wind.mp4" -map 0:a -c copy -f adts "$work/before.aac" </dev/null
  ffmpeg -v error -i "$work/joined.ts" -map 0:a -c copy -f adts "$work/after.aac" </dev/null
  python3 -c 'import sys; before, after = (open(name, "rb").read() for name in sys.argv[1:])
print(len(before), len(after)); sys.exit(after not in before or len(after) < 0.98 * len(before))' "$work/before.aac" "$work/after.aac"
}
promise "nor a byte of the sound" same_sound

# What is there stays, and other options are made anew.
promise "it is not made again" says 0 "there already" package --output "$work/film" "$work/wind.mp4"
cp -r "$work/film" "$work/both"
promise "another carriage replaces it" says 0 "written: ts-" package --carriage ts --output "$work/both" "$work/wind.mp4"
promise "with the same bytes" diff -r "$work/ts" "$work/both"
promise "a copy that was authored gives its track" says 0 "225 fields" package --output "$work/copy" "$work/wind.haptic.ts"

# The MP4 as it is, and its track as one file, for the element of the player.
mkdir "$FEELING_WIND_WEB/player"
promise "a single film needs the player in one file" says 1 "feeling-wind.min.js" package --single --output "$work/single" "$work/wind.mp4"
echo '/*! one file */' >"$FEELING_WIND_WEB/player/feeling-wind.min.js"
echo 'MIT' >"$FEELING_WIND_WEB/player/LICENSE"
echo '<feeling-wind src="film.mp4" track="film.klv">' >"$FEELING_WIND_WEB/single.html"
promise "a single film has one track beside it" says 0 "written: film.mp4 and film.klv" \
  package --single --output "$work/single" "$work/wind.mp4"
promise "the film stays as it is" cmp "$work/wind.mp4" "$work/single/film.mp4"
promise "what is needed is there, with its licence" test "$(ls -A "$work/single")" = "LICENSE
feeling-wind.min.js
film.klv
film.mp4
index.html"
promise "the page is the one for a single film" cmp "$FEELING_WIND_WEB/single.html" "$work/single/index.html"
times_of() { "$haptic_track" info "$1" | grep -E 'fields|time'; }
promise "its fields begin with the film" says 0 "0.000 to " times_of "$work/single/film.klv"
promise "a converted copy has the same track" "$haptic_track" convert --force "$work/wind.haptic.ts" "$work/single.klv"
promise "at the same times" test "$(times_of "$work/single.klv")" = "$(times_of "$work/single/film.klv")"
promise "it is not made again" says 0 "there already: film.klv" package --single --output "$work/single" "$work/wind.mp4"
promise "with other settings it is" says 0 "written: film.mp4 and film.klv" \
  package --single --columns 16 --output "$work/single" "$work/wind.mp4"
"$haptic_track" cut --from 0 --to 2 "$work/single/film.klv" "$work/other.klv"
cp "$work/other.klv" "$work/single/film.klv"
promise "a track that is not that of the film is made anew" says 0 "written: film.mp4 and film.klv" \
  package --single --output "$work/single" "$work/wind.mp4"
mkdir "$work/videos"
echo 'my film' >"$work/videos/film.mp4"
promise "a film of that name is not written over" says 1 "this folder has another film.mp4" \
  package --single --output "$work/videos" "$work/wind.mp4"
promise "it stays" test "$(cat "$work/videos"/*)" = 'my film'
promise "only one MP4 is taken" says 1 "--single takes one MP4" package --single --output "$work/no" "$work/wind.haptic.ts"
promise "a site of segments is not written over" says 1 "this folder has another index.html" \
  package --single --output "$work/film" "$work/wind.mp4"
promise "--single and --carriage do not go together" says 1 "carriage" \
  package --single --carriage ts --output "$work/no" "$work/wind.mp4"
rm -r "$FEELING_WIND_WEB"/{player,single.html}

# A film with a surface, as a stream of its own, and alone.
# `with_surface FILE [BRANCH...]`: the authored copy without its track, and reliefs of its colours.
with_surface() {
  local file=$1
  shift
  gst-launch-1.0 -q mpegtsmux name=mux ! filesink "location=$file" \
    filesrc "location=$work/wind.haptic.ts" ! tsdemux name=demux demux. ! video/x-h264 ! h264parse ! tee name=film \
    film. ! queue ! mux.sink_65 film. ! queue ! avdec_h264 ! videoconvert ! video/x-raw,format=RGB ! reliefmap ! hapticconvert \
    ! meta/x-klv ! queue ! mux.sink_66 "$@"
}
promise "a film with motion and surface is made" with_surface "$work/touched.ts" demux. ! meta/x-klv ! queue ! mux.sink_67
promise "and one with a surface alone" with_surface "$work/surface.ts"
for carriage in mp4 ts; do
  promise "both are packaged as $carriage" says 0 "225 fields, 225 reliefs" \
    package --carriage "$carriage" --output "$work/touched-$carriage" "$work/touched.ts"
  promise "as they should be" check "$work/touched-$carriage"
done
promise "so is the surface alone" says 0 "0 fields, 225 reliefs" package --output "$work/surface" "$work/surface.ts"
promise "as it should be" check "$work/surface"
# The same in Matroska, as lines of text.
gst-launch-1.0 -q matroskamux name=mux ! hapticmark ! filesink "location=$work/surface.mkv" \
  filesrc "location=$work/surface.ts" ! tsdemux name=demux demux. ! video/x-h264 ! h264parse ! queue ! mux. \
  demux. ! meta/x-klv ! hapticconvert ! text/x-raw ! queue ! mux.
promise "and the surface alone in Matroska" says 0 "0 fields, 225 reliefs" package --output "$work/surface-mkv" "$work/surface.mkv"
gst-launch-1.0 -q matroskamux name=mux ! hapticmark ! filesink "location=$work/point.mkv" \
  filesrc "location=$work/wind.haptic.ts" ! tsdemux ! video/x-h264 ! h264parse ! tee name=film film. ! queue ! mux. \
  film. ! queue ! avdec_h264 ! roitracker ! velocityavg ! hapticconvert ! text/x-raw ! queue ! mux.
promise "a track of one point in Matroska is refused for that reason" says 1 "has the motion of one point" \
  package --output "$work/point" "$work/point.mkv"
promise "another program reads the motion beside it" \
  says 0 "fields     100" "$haptic_track" info "$(echo "$work"/touched-ts/ts-*/00001.ts)"

killed_and_again() {
  local delay
  for delay in 0.1 0.2 0.4; do
    rm -rf "$work/again"
    "$haptic_track" package --output "$work/again" "$work/wind.mp4" >/dev/null 2>&1 &
    sleep "$delay"
    kill -KILL $! 2>/dev/null || true
    wait $! 2>/dev/null || true
    until package --output "$work/again" "$work/wind.mp4" >"$work/output" 2>&1; do
      grep -q 'another process is writing' "$work/output" || return 1
      sleep 0.05
    done
    diff -r "$work/film" "$work/again" || return 1
  done
}
promise "killed and run again it makes the same bytes" killed_and_again
interrupted_and_again() {
  local signal status
  for signal in INT TERM; do
    rm -rf "$work/again"
    status=0
    "$haptic_track" package --output "$work/again" "$work/wind.mp4" >"$work/output" 2>&1 &
    until [ -e "$work/again/.package.lock" ]; do sleep 0.01; done
    kill "-$signal" $!
    wait $! || status=$?
    cat "$work/output"
    [ $status = 130 ] && ! grep -q wind.mp4 "$work/output" || return 1
    [ ! -e "$work/again/.package.lock" ] && [ -z "$(find "$work/again" -name '*.part')" ] || return 1
    package --output "$work/again" "$work/wind.mp4" && diff -r "$work/film" "$work/again" || return 1
  done
}
promise "interrupted it ends with a sentence, and goes on as well" interrupted_and_again

# Bit rates.
film "$work/small.mp4" 176
ffmpeg -v error -t 5 -i "$work/wind.mp4" -c copy "$work/other.mp4" </dev/null
ffmpeg -v error -i "$work/wind.mp4" -vf scale=288:288,setsar=1 -c:v libx264 -preset veryfast -c:a copy "$work/square.mp4" </dev/null
promise "two bit rates share one track" package --output "$work/rates" "$work/wind.mp4" "$work/small.mp4"
promise "and are what they should be" check "$work/rates"
same_fields() { [ "$(check "$work/rates" | cut -d' ' -f2-)" = "$({ check "$work/film"; check "$work/film"; } | cut -d' ' -f2-)" ]; }
promise "with the same fields" same_fields
promise "other lengths are refused" says 1 "they last" package --output "$work/no" "$work/wind.mp4" "$work/other.mp4"
promise "and other shapes" says 1 "their frames are" package --output "$work/no" "$work/wind.mp4" "$work/square.mp4"
promise "and one film twice" says 1 "they are the same file" package --output "$work/no" "$work/wind.mp4" "$work/wind.mp4"

# What a browser does not play is said before work begins.
odd() { ffmpeg -v error -f lavfi -i testsrc2=s=192x144:r=25:d=2 -f lavfi -i sine=d=2 "$@" </dev/null; }
odd -pix_fmt yuv444p -c:v libx264 "$work/444.mp4"
odd -pix_fmt yuv420p -c:v libx264 -c:a mp2 "$work/mp2.ts"
odd -pix_fmt yuv420p -c:v libx264 -flags +ildct+ilme "$work/interlaced.mp4"
odd -pix_fmt yuv420p -c:v mpeg4 "$work/mpeg4.mp4"
lay_on_its_side "$work/wind.mp4" "$work/turned.mp4"
promise "a profile that browsers lack" says 1 "does not play H.264 of the profile high-4:4:4" package --output "$work/no" "$work/444.mp4"
promise "sound that they lack" says 1 "does not play its sound" package --output "$work/no" "$work/mp2.ts"
promise "interlaced frames" says 1 "does not play interlaced frames" package --output "$work/no" "$work/interlaced.mp4"
promise "another codec" says 1 "ffmpeg -i VIDEO" package --output "$work/no" "$work/mpeg4.mp4"
promise "frames on their side" says 1 "frames that lie on their side" package --output "$work/no" "$work/turned.mp4"
echo 'no video' >"$work/none.mp4"
promise "a file that is none" says 1 "none.mp4" package --output "$work/no" "$work/none.mp4"
promise "no player" says 1 "the web player is not there" env FEELING_WIND_WEB="$work/missing" \
  "$haptic_track" package --output "$work/no" "$work/wind.mp4"
promise "and nothing was made" test ! -e "$work/no"
odd -pix_fmt yuv420p -c:v libx264 -g 1000 -vf 'setpts=5*PTS' -an "$work/long.mp4"
promise "long segments are said" says 0 "segments of up to 10" package --output "$work/long" "$work/long.mp4"
mkdir "$work/site"
echo 'my site' >"$work/site/index.html"
promise "another site is not written over" says 1 "this folder has another index.html" package --output "$work/site" "$work/wind.mp4"
promise "it stays" grep -qx 'my site' "$work/site/index.html"
mkdir "$work/mine"
for name in poster.jpg player.js; do
  echo 'my work' >"$work/mine/$name"
  promise "nor is another $name" says 1 "this folder has another $name" package --output "$work/mine" "$work/wind.mp4"
  promise "it stays" test "$(cat "$work/mine/$name")" = 'my work'
  rm "$work/mine/$name"
done
promise "a full disk" says 1 "cannot be written" bash -c "ulimit -f 50; '$haptic_track' package --output '$work/full' '$work/wind.haptic.ts'"
promise "leaves nothing under a final name" test "$(ls "$work/full")" = ""

# Other streams.
printf '1\n00:00:00,500 --> 00:00:01,000\nmy words\n' >"$work/words.srt"
odd -pix_fmt yuv420p -c:v libx264 "$work/short.mp4"
ffmpeg -v error -i "$work/short.mp4" -i "$work/words.srt" -c:v copy -c:a copy -c:s mov_text "$work/words.mp4" </dev/null
promise "subtitles are left out, which is said" says 0 "a further stream was left out: text/" \
  package --output "$work/words" "$work/words.mp4"

# The sound ends early: 45 MB of frames are not kept until the film ends.
noise() {
  head -c 31104000 /dev/urandom | ffmpeg -v error -f rawvideo -pix_fmt yuv420p -s 192x144 -r 25 -i - "$@" \
    -c:v libx264 -preset ultrafast -qp 6 -g 50 -c:a aac "$work/noise.mp4" &&
    mkvmerge -q -o "$work/noise.mkv" "$work/noise.mp4" -D -A "$work/track.haptic.mkv"
}
# The largest memory of a process, in KiB.
peak_of() {
  python3 - "$@" <<'END'
import subprocess, sys, time
program = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
peak = 0
while program.poll() is None:
    with open(f"/proc/{program.pid}/status") as status:
        peak = max([peak] + [int(line.split()[1]) for line in status if line.startswith("VmHWM")])
    time.sleep(0.01)
print(peak)
sys.exit(program.returncode)
END
}
early_end() {
  local without with
  ffmpeg -v error -f lavfi -i testsrc=s=64x48:r=25:d=30 -c:v libx264 -preset ultrafast "$work/track.mkv" </dev/null &&
    "$haptic_track" author --output "$work" "$work/track.mkv" >/dev/null &&
    noise && without=$(peak_of "$haptic_track" package --output "$work/noise" "$work/noise.mkv") &&
    rm -r "$work"/noise* && noise -f lavfi -i sine=d=1 &&
    with=$(peak_of "$haptic_track" package --output "$work/noise" "$work/noise.mkv") &&
    rm -r "$work"/noise* || return 1
  echo "$((without / 1024)) MB without sound, $((with / 1024)) MB with sound that ends after 1 s of 30 s"
  [ "$with" -lt $((without + 12000)) ]
}
if command -v mkvmerge >/dev/null; then
  promise "a film whose sound ends early takes no more memory" early_end
fi

# Of 30000/1001 frames a second, in Matroska too, whose times are rounded to ms.
rate_of() { sed -n 's/.*FRAME-RATE=//p' "$1/film.m3u8"; }
for ending in mp4 mkv; do
  ffmpeg -v error -f lavfi -i testsrc=s=64x48:r=30000/1001:d=5 -c:v libx264 -preset ultrafast -pix_fmt yuv420p \
    "$work/ntsc.$ending" </dev/null
  promise "NTSC in .$ending is packaged" package --output "$work/ntsc-$ending" "$work/ntsc.$ending"
  promise "with its frame rate" test "$(rate_of "$work/ntsc-$ending")" = 29.970
done

# Frames at uneven times.
odd -vf "select='not(mod(n,7))+not(mod(n,5))'" -fps_mode vfr -pix_fmt yuv420p -c:v libx264 "$work/uneven.mp4"
promise "uneven frames keep their times" package --output "$work/uneven" "$work/uneven.mp4"
promise "and their fields too" check "$work/uneven"
