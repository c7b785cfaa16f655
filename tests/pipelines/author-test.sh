#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track author: what the copies hold, that they can be trusted, and what happens when something goes wrong.

source "$(dirname "$0")/support.sh"

haptic_track=$build/gst-plugins/track/tools/haptic-track
use_elements motionfield hapticconvert
for element in x264enc avdec_h264; do
  gst-inspect-1.0 --exists "$element" || skip "there is no element $element"
done

# `video FILE WIDTH SECONDS [MUXER]`: H.264 whose left half moves up and the right one down, with sound.
video() {
  "$MAKE_CLIP" "$2" 288 30 "$3" halves:0,-100,0,100 |
    gst-launch-1.0 -q fdsrc ! rawvideoparse format=gray8 "width=$2" height=288 framerate=30/1 ! videoconvert \
      ! x264enc tune=zerolatency key-int-max=30 ! h264parse ! queue ! mux. \
      audiotestsrc "num-buffers=$((43 * $3))" ! audioconvert ! avenc_aac ! aacparse ! queue ! mux. \
      "${4:-mp4mux}" name=mux ! filesink "location=$1"
}
author() { "$haptic_track" author "$@"; }
# `says STATUS TEXT COMMAND...`
says() {
  local status=0 wanted=$1 text=$2
  shift 2
  "$@" >"$work/output" 2>&1 || status=$?
  cat "$work/output"
  [ "$status" = "$wanted" ] && grep -qF -- "$text" "$work/output"
}
# The coded pictures, whatever stands around them: `essence FILE`.
essence() {
  ffmpeg -v error -i "$1" -map 0:v:0 -c copy -bsf:v h264_mp4toannexb,filter_units=remove_types=6-9 -f h264 - | md5sum
}
same_essence() { [ "$(essence "$1")" = "$(essence "$2")" ]; }

mkdir "$work/in" "$work/out"
video "$work/in/wind.mp4" 352 4
video "$work/in/sea.mkv" 352 2 matroskamux

promise "two videos get their copies" says 0 "2 written, 0 there already, 0 failed" \
  author --jobs 2 --output "$work/out" "$work/in/wind.mp4" "$work/in/sea.mkv"
small() { local mb; mb=$(sed -n 's/.* at most \([0-9]*\) MB a process/\1/p' "$work/output") && [ "$mb" -gt 0 ] && [ "$mb" -le 150 ]; }
promise "in no more than 150 MB each" small
promise "the picture of an MP4 is untouched" same_essence "$work/in/wind.mp4" "$work/out/wind.haptic.ts"
promise "and that of Matroska" same_essence "$work/in/sea.mkv" "$work/out/sea.haptic.mkv"
no_player_shows_it() {
  ffprobe -v error -select_streams s -show_entries stream_disposition=default,forced -of csv=p=0 "$1" | grep -x 0,0
}
promise "no player shows the track as subtitles" no_player_shows_it "$work/out/sea.haptic.mkv"
language_of() { ffprobe -v error -select_streams s -show_entries stream_tags=language -of csv=p=0 "$1"; }
promise "whatever the user's language" test "$(language_of "$work/out/sea.haptic.mkv")" = zxx
promise "nor one that was converted" haptic_track convert "$work/out/wind.haptic.ts" "$work/alone.mkv"
promise "without being asked" no_player_shows_it "$work/alone.mkv"
promise "the sound is there" says 0 "audio/mpeg" "$haptic_track" info "$work/out/wind.haptic.ts"
promise "there is a field for each picture" says 0 "fields     120" "$haptic_track" info "$work/out/wind.haptic.ts"
promise "they are not done again" says 0 "0 written, 2 there already, 0 failed" \
  author --output "$work/out" "$work/in/wind.mp4" "$work/in/sea.mkv"

# A part that begins between two key fields has nothing that depends on what was cut off.
every_field_decodes() {
  local count
  "$haptic_track" cut --from 0.4 --to 2.4 "$1" "$work/part.ts" || return 1
  gst-launch-1.0 -v filesrc "location=$work/part.ts" ! tsdemux ! meta/x-klv ! hapticconvert ! haptics/x-raw \
    ! identity silent=false ! fakesink >"$work/part.log" 2>&1 || return 1
  count=$(grep -c 'last-message = chain' "$work/part.log") || return 1
  echo "$count fields"
  ! grep 'fields were lost' "$work/part.log" && [ "$count" = 60 ]
}
promise "every field of a part can be decoded" every_field_decodes "$work/out/wind.haptic.ts"

# A hand that moves to the other half 0.5 s behind the first frame of the video, which the containers have at other times.
printf 'time,fx,fy,x,y\n0,0,0,-0.02,0\n0.499,0,0,0.02,0\n' >"$work/step.csv"
ffmpeg -v error -i "$work/in/wind.mp4" -c copy "$work/wind.mkv" </dev/null
author "$work/wind.mkv" >/dev/null
steps_at_half_a_second() {
  "$haptic_track" convert --force --hand "$work/step.csv" "$1" "$work/step.txt" || return 1
  awk -v RS='hv1 ' '/^point/ { n++; split($0, words, " x="); if (words[2] + 0 > 0.5 && !first) first = n }
    END { print "frame " first; exit first != 16 }' "$work/step.txt"
}
for copy in "$work/out/wind.haptic.ts" "$work/wind.haptic.mkv"; do
  promise "a log counts from the first frame of ${copy##*.}" steps_at_half_a_second "$copy"
done

# Tuned into the middle, cut between two packets.
frames_from_the_middle() {
  local half count
  half=$(($(stat -c %s "$1") / 188 / 2))
  tail -c "+$((half * 188 + 1))" "$1" >"$work/middle.ts"
  count=$(ffprobe -v fatal -select_streams v -count_frames -show_entries stream=nb_read_frames -of csv=p=0 "$work/middle.ts" |
    sed -n 1p) || return 1
  echo "$count frames"
  [ "$count" -ge 25 ]
}
promise "who tunes in later sees the picture" frames_from_the_middle "$work/out/wind.haptic.ts"

# A part of film and track. In both, the first picture is the key frame at 1 s, and its field has its time.
ffmpeg -v error -i "$work/in/wind.mp4" -c:v libx264 -preset veryfast -g 30 -bf 2 -c:a copy "$work/reordered.mp4"
author "$work/reordered.mp4" >/dev/null
in_step() {
  ffprobe -v error -show_entries packet=codec_type,pts_time -of csv=p=0 "$1" | tr -d ' ' | awk -F, '
    $1 == "video" && (!(1 in seen) || $2 < video) { video = $2; seen[1] }
    $1 == "data" || $1 == "subtitle" { if (!(2 in seen) || $2 < track) { track = $2; seen[2] } }
    $1 == "video" { pictures++ }
    END { print pictures " pictures from " video ", fields from " track
          exit !(pictures == 60 && video - track < 0.002 && track - video < 0.002) }'
}
for ending in ts mkv; do
  promise "film and track are cut at key frames ($ending)" "$haptic_track" cut --with-video --from 1.4 --to 2.6 \
    "$work/reordered.haptic.ts" "$work/film.$ending"
  promise "and stay in step" in_step "$work/film.$ending"
  promise "every picture can be decoded" test -z "$(ffprobe -v error -count_frames "$work/film.$ending" 2>&1)"
  promise "with as many fields" says 0 "fields     60" "$haptic_track" info "$work/film.$ending"
done
promise "behind its end there is nothing to cut" says 1 'no sample between these times' \
  "$haptic_track" cut --with-video --from 100 --to 110 "$work/reordered.haptic.ts" "$work/behind.ts"
promise "nor backwards" says 1 'no sample between these times' \
  "$haptic_track" cut --with-video --from 2 --to 1 "$work/reordered.haptic.ts" "$work/behind.ts"
promise "a film is no bare track" says 1 "must end in .ts or .mkv" "$haptic_track" cut --with-video "$work/reordered.haptic.ts" "$work/film.klv"

ffmpeg -v error -i "$work/reordered.mp4" -c copy "$work/from-matroska.mkv" </dev/null
author "$work/from-matroska.mkv" >/dev/null
promise "frames without decoding times are not cut into MPEG-TS" says 1 'have no decoding times' \
  "$haptic_track" cut --with-video --from 1.4 --to 2.6 "$work/from-matroska.haptic.mkv" "$work/no.ts"
promise "but into Matroska" "$haptic_track" cut --with-video --from 1.4 --to 2.6 "$work/from-matroska.haptic.mkv" "$work/cut.mkv"
promise "with every picture" in_step "$work/cut.mkv"
clip "$work/jpegs.mkv" 352 288 30 2 uniform:60,0
author "$work/jpegs.mkv" >/dev/null
promise "no part leaves its video out" says 1 'the muxer cannot hold image/jpeg' \
  "$haptic_track" cut --with-video --from 0 --to 1 "$work/jpegs.haptic.mkv" "$work/no.ts"
promise "and there is no file" test ! -e "$work/no.ts"

# A replaced video, or another setting.
mkdir "$work/new"
cp "$work/in/sea.mkv" "$work/new/film.mkv"
promise "a new video is authored" says 0 "1 written" author "$work/new/film.mkv"
cp -p "$work/new/film.haptic.mkv" "$work/before.mkv"
promise "and not again" says 0 "0 written, 1 there already" author "$work/new/film.mkv"
promise "with other columns it is" says 0 "1 written" author --columns 16 "$work/new/film.mkv"
promise "once" says 0 "0 written, 1 there already" author --columns 16 "$work/new/film.mkv"
promise "with things to hold it is" says 0 "1 written" author --hold auto --hold 0.25,0.5@0.5 "$work/new/film.mkv"
promise "once, too" says 0 "0 written, 1 there already" author --hold auto --hold 0.25,0.5@0.5 "$work/new/film.mkv"
followed() { [ "$("$haptic_track" info "$1" | sed -n 's/^  things *//p')" -ge "$2" ]; }
promise "the copy has them" followed "$work/new/film.haptic.mkv" 10
promise "a part has them" "$haptic_track" cut --from 0.7 --to 1.6 "$work/new/film.haptic.mkv" "$work/part.klv"
promise "in every field" followed "$work/part.klv" 10
promise "a place outside the frame is refused" says 1 "--hold cannot be '1.5,0'" author --hold 1.5,0 "$work/new/film.mkv"
video "$work/new/film.mkv" 320 2 matroskamux
promise "a replaced video is authored anew" says 0 "1 written" author "$work/new/film.mkv"
promise "with its own motion" says 0 "frame      320 x 288" "$haptic_track" info "$work/new/film.haptic.mkv"
rm "$work/new/film.mkv"
cp "$work/in/wind.mp4" "$work/new/film.mp4"
promise "so is one in another container" says 0 "1 written" author "$work/new/film.mp4"
promise "and one copy is left" test "$(ls "$work/new")" = "$(printf 'film.haptic.ts\nfilm.mp4')"


# Videos of one name in two containers.
mkdir "$work/same"
cp "$work/in/wind.mp4" "$work/same/film.mp4"
promise "the first of two videos of one name is authored" author "$work/same/film.mp4"
cp "$work/in/sea.mkv" "$work/same/film.mkv"
promise "the second is refused" says 1 'film.haptic.ts": this file may be the copy of another' author "$work/same/film.mkv"
promise "the copy of the first stays" says 0 "1 there already" author "$work/same/film.mp4"
cp "$work/out/sea.haptic.mkv" "$work/same/film.haptic.mkv"
rm "$work/same/film.mkv"
promise "so does a copy of a video elsewhere" author "$work/same/film.mp4"
promise "in another container" test "$(ls "$work/same")" = "$(printf 'film.haptic.mkv\nfilm.haptic.ts\nfilm.mp4')"

# Videos of one name in several folders.
mkdir "$work"/{one,two,three,shared}
cp "$work/in/wind.mp4" "$work/one/film.mp4"
video "$work/two/film.mp4" 320 1
video "$work/three/film.mkv" 320 1 matroskamux
promise "the video of one folder is authored" author --output "$work/shared" "$work/one/film.mp4"
cp "$work/shared/film.haptic.ts" "$work/first.ts"
promise "that of another, with its name, is refused" says 1 'film.haptic.ts": this file may be the copy of another' \
  author --output "$work/shared" "$work/two/film.mp4"
promise "in another container it has another copy" author --output "$work/shared" "$work/three/film.mkv"
promise "and the first one stays" cmp "$work/first.ts" "$work/shared/film.haptic.ts"

# Subtitles, of which a word begins as a line of the track does.
printf '1\n00:00:00,000 --> 00:00:01,000\nhvis du vil hjem.\n' >"$work/danish.srt"
ffmpeg -v error -i "$work/in/wind.mp4" -i "$work/danish.srt" -map 0:v -map 1 -c copy -c:s mov_text "$work/danish.mp4" </dev/null
promise "words are no track" says 1 'no haptic track in this file, only' "$haptic_track" info "$work/danish.mp4"
promise "and a film with them is authored" says 0 "1 written" author "$work/danish.mp4"

# Fields that author did not write are somebody's work.
mkdir "$work/own"
cp "$work/in/wind.mp4" "$work/own/film.mp4"
author "$work/own/film.mp4" >/dev/null
"$haptic_track" convert "$work/own/film.haptic.ts" "$work/own/film.haptic.mkv" 2>/dev/null
promise "a converted copy is left alone" says 0 "1 there already" author "$work/own/film.mp4"
rm "$work/own/film.haptic.ts"
promise "so it is when a new one is written" says 0 "1 written" author "$work/own/film.mp4"
promise "and it is there" test "$(ls "$work/own")" = "$(printf 'film.haptic.mkv\nfilm.haptic.ts\nfilm.mp4')"
"$haptic_track" cut --with-video --from 0 --to 1 "$work/own/film.haptic.ts" "$work/own-part.ts"
cp "$work/own-part.ts" "$work/own/film.haptic.ts"
promise "a part of one is not written over" says 1 'is no copy that author made' author "$work/own/film.mp4"
promise "it stays" cmp "$work/own-part.ts" "$work/own/film.haptic.ts"

# Two of one name in one call are found before work begins.
mkdir "$work/elsewhere"
cp "$work/in/sea.mkv" "$work/elsewhere/wind.mkv"
both=("$work/in/wind.mp4" "$work/elsewhere/wind.mkv")
promise "two videos of one name are refused" says 1 "Nothing was written" author --output "$work/same" "${both[@]}"
promise "in a plan too" says 1 "Nothing was written" author --plan --output "$work/same" "${both[@]}"
no_copy_was_made() { ! compgen -G "$work/same/wind*"; }
promise "and no copy was made" no_copy_was_made
promise "into their own folders they go" says 0 "1 written, 0 there already, 0 failed" author "$work/elsewhere/wind.mkv" "$work/elsewhere/wind.mkv"

# A recording has a track.
cp "$work/out/wind.haptic.ts" "$work/recorded.ts"
cp "$work/out/sea.haptic.mkv" "$work/recorded.mkv"
for ending in ts mkv; do
  promise "a recording ($ending) gets no second track" says 1 "there is a haptic track in this file already" \
    env G_DEBUG=fatal-criticals "$haptic_track" author "$work/recorded.$ending"
done

# `felt FILE DEMUXER CAPS PLACE SIGN [COLUMN]`: a hand there feels its half of the picture.
felt() {
  gst-launch-1.0 -q filesrc "location=$1" ! "$2" ! "$3" ! hapticconvert ! hapticsink device=sim "sim-hand=hold:$4" \
    "log-location=$work/felt.csv" || return 1
  awk -F, -v "sign=$5" -v "column=${6:-9}" 'NR > 1 && $column * sign > 0.4 { right++ } NR > 1 && $column * sign < -0.1 { wrong++ }
    END { print right + 0 " ms in the right direction, " wrong + 0 " in the other"
          exit !(right > 500 && wrong == 0) }' "$work/felt.csv"
}
promise "on the left one feels the motion up" felt "$work/out/wind.haptic.ts" tsdemux meta/x-klv -0.5,0,0 1
promise "on the right the motion down" felt "$work/out/sea.haptic.mkv" matroskademux text/x-raw 0.5,0,0 -1

promise "a parent that ignores its children does not matter" says 0 "1 there already" \
  timeout 60 env --ignore-signal=CHLD "$haptic_track" author --output "$work/out" "$work/in/wind.mp4"

# Killed at any moment, and run again: the same bytes.
killed_and_again() {
  local delay
  for delay in 0.15 0.3 0.45 0.6; do
    rm -rf "$work/again"
    mkdir "$work/again"
    "$haptic_track" author --jobs 2 --output "$work/again" "$work"/in/* >/dev/null 2>&1 &
    sleep "$delay"
    kill -KILL $!
    wait $! 2>/dev/null || true
    while pgrep -f "author --jobs 2 --output $work/again" >/dev/null; do sleep 0.02; done
    author --output "$work/again" "$work"/in/* >/dev/null 2>&1 || return 1
    diff -r "$work/out" "$work/again" || return 1
  done
}
promise "killed and run again it makes the same bytes" killed_and_again

# Frames of AVI that depend on others have no presentation time.
for codec in 'mpeg4 ts' 'msmpeg4v3 mkv'; do
  read -r codec ending <<<"$codec"
  ffmpeg -v error -i "$work/in/wind.mp4" -an -c:v "$codec" -g 300 "$work/$codec.avi"
  promise "an AVI of $codec is authored" author "$work/$codec.avi"
  promise "to its end" says 0 120 ffprobe -v fatal -select_streams v -count_frames -show_entries stream=nb_read_frames \
    -of csv=p=0 "$work/$codec.haptic.$ending"
  promise "with a field for each picture" says 0 "fields     120" "$haptic_track" info "$work/$codec.haptic.$ending"
done

# Other streams.
printf '1\n00:00:00,500 --> 00:00:01,000\nmy <i>words</i> & < yours\n' >"$work/words.srt"
ffmpeg -v error -i "$work/in/wind.mp4" -i "$work/words.srt" -c:v copy -c:a copy -c:s mov_text "$work/text.mp4"
lay_on_its_side "$work/in/wind.mp4" "$work/turned.mp4"
ffmpeg -v error -i "$work/in/wind.mp4" -i "$work/in/sea.mkv" -map 0 -map 1:v -c copy "$work/two.mp4"
promise "a second video goes along" author "$work/two.mp4"
promise "as it was" says 0 "60" ffprobe -v fatal -select_streams v:1 -count_frames -show_entries stream=nb_read_frames \
  -of csv=p=0 "$work/two.haptic.ts"
promise "beside the track of the first" says 0 "fields     120" "$haptic_track" info "$work/two.haptic.ts"
# Sound that begins late: its parameters come with its first frame.
late_sound() {
  ffmpeg -v error -f lavfi -i "testsrc2=size=$2:rate=25:duration=12" -itsoffset 10 -f lavfi -i sine=duration=2 -map 0 -map 1 \
    -vf "noise=alls=$3:allf=t" -c:v libx264 -preset ultrafast -qp "$4" -g 50 -pix_fmt yuv420p -c:a aac "$1"
}
frames_of_sound() {
  ffprobe -v error -select_streams a -count_packets -show_entries stream=nb_read_packets -of csv=p=0 "$1" | sed -n 1p
}
late_sound "$work/late.ts" 192x108 0 30
promise "sound that begins after ten seconds goes along" author "$work/late.ts"
promise "all of it" test "$(frames_of_sound "$work/late.ts")" = "$(frames_of_sound "$work/late.haptic.ts")"
# More pictures stand beside no sound than memory may hold: the muxers wait for it, and the demuxers for them.
mkdir "$work/silent"
late_sound "$work/silent/late.ts" 480x270 60 1
late_sound "$work/silent/later.mkv" 480x270 60 1
ffmpeg -v error -i "$work/silent/late.ts" -f lavfi -i sine=duration=2 -map 0:v -map 1 -c:v copy -c:a aac "$work/silent/early.mkv"
promise "a film that stands still is refused" says 1 "0 written, 0 there already, 3 failed" author --jobs 3 "$work"/silent/*
promise "each with the reason" test "$(grep -c 'frames have no sound beside them' "$work/output")" = 3
promise "and no copy is left" test "$(ls "$work/silent")" = "$(printf 'early.mkv\nlate.ts\nlater.mkv')"
# `words_stay CODEC`: Matroska to Matroska, the words and their times as FFmpeg reads them.
words() { ffmpeg -v error -i "$1" -map "0:s:$2" -f srt - | sed 's/,[0-9]* / /; s/,[0-9]*$//'; }
words_stay() {
  ffmpeg -v error -i "$work/in/sea.mkv" -i "$work/words.srt" -c copy -c:s "$1" "$work/words-$1.mkv" &&
    author "$work/words-$1.mkv" && [ "$(words "$work/words-$1.mkv" 0)" = "$(words "$work/words-$1.haptic.mkv" 1)" ]
}
promise "subtitles of Matroska stay" words_stay srt
promise "and those with a style" words_stay ass
promise "subtitles have no place in MPEG-TS, which is said" says 0 "a further stream was left out" author "$work/text.mp4"

# A film that lies on its side stays upright: each picture says so, and the field is of the upright frame.
ffmpeg -v error -i "$work/turned.mp4" -f lavfi -i sine=duration=4 -map 0:v -map 1 -c:v copy -c:a flac -strict -2 \
  "$work/turned-flac.mp4"
lacks() { ! "${@:2}" | grep -F -- "$1"; }
for copy in turned.haptic.ts turned-flac.haptic.mkv; do
  promise "a film on its side is authored" says 0 "1 written" author "$work/${copy%%.*}.mp4"
  promise "$copy holds its rotation in each picture" test "$(ffprobe -v fatal -select_streams v -show_entries \
    frame_side_data=rotation -of csv=p=0 "$work/$copy" | grep -cE '(^|,)90$')" = 120
  promise "the scripts turn it" test "$(upright_direction "$work/$copy")" = 90l
  promise "nothing is odd about it" lacks remark "$haptic_track" info "$work/$copy"
  promise "a field is upright" says 0 "frame      288 x 352 px" "$haptic_track" info "$work/$copy"
done
promise "below one feels the motion to the left" felt "$work/turned.haptic.ts" tsdemux meta/x-klv "0,-0.5,0" -1 8
promise "above to the right" felt "$work/turned-flac.haptic.mkv" matroskademux text/x-raw "0,0.5,0" 1 8
promise "a browser would show it on its side" says 1 "lie on their side" \
  env FEELING_WIND_WEB="$root/pipelines/web" "$haptic_track" package --output "$work" "$work/turned.haptic.ts"

# Codecs that MPEG-TS has no place for. `coded FILE`: its coded pictures.
coded() { ffmpeg -v error -i "$1" -map 0:v -c copy -f data - | md5sum; }
kept_whole() { [ "$(coded "$1")" = "$(coded "$2")" ] && [ -z "$(ffprobe -v error -count_frames "$2" 2>&1)" ]; }
if gst-inspect-1.0 --exists av1dec || gst-inspect-1.0 --exists dav1ddec; then
  ffmpeg -v error -t 1 -i "$work/in/wind.mp4" -c:v libaom-av1 -cpu-used 8 -usage realtime -c:a copy "$work/av1.mp4"
  promise "AV1 goes into Matroska" says 0 "1 written" author "$work/av1.mp4"
  promise "with a field for each picture" says 0 "fields     30" "$haptic_track" info "$work/av1.haptic.mkv"
  promise "as it was" kept_whole "$work/av1.mp4" "$work/av1.haptic.mkv"
fi
ffmpeg -v error -t 1 -i "$work/in/wind.mp4" -vf scale=1280:720,fps=25 -c:v dnxhd -b:v 60M -pix_fmt yuv422p \
  -c:a pcm_s16le -ar 48000 -ac 1 "$work/dnxhd.mxf"
promise "DNxHD of MXF too" says 0 "in Matroska, GStreamer does not know DNxHD" author "$work/dnxhd.mxf"
promise "with a field for each picture" says 0 "fields     25" "$haptic_track" info "$work/dnxhd.haptic.mkv"
promise "and its pictures are whole" kept_whole "$work/dnxhd.mxf" "$work/dnxhd.haptic.mkv"

# What cannot be done is said, and the rest goes on.
head -c $(($(stat -c %s "$work/in/sea.mkv") / 3)) "$work/in/sea.mkv" >"$work/half.mkv"
head -c 3000 "$work/in/wind.mp4" >"$work/short.mp4"
gst-launch-1.0 -q audiotestsrc num-buffers=20 ! wavenc ! filesink "location=$work/sound.wav"
echo 'no video' >"$work/none.mp4"
video "$work/narrow.ts" 320 1 mpegtsmux
video "$work/wide.ts" 352 1 mpegtsmux
cat "$work/narrow.ts" "$work/wide.ts" >"$work/turns.ts"
mkdir "$work/foreign"
echo 'my notes' >"$work/foreign/wind.haptic.ts"

ffmpeg -v error -i "$work/in/wind.mp4" -f lavfi -i sine=duration=12 -map 0:v -map 1 -c:v copy -c:a aac "$work/song.mp4"
promise "sound that goes on after the picture" says 0 "1 written" author "$work/song.mp4"
promise "a file that ends in the middle" says 1 "It was not copied or recorded to its end" author "$work/half.mkv"
promise "a file that ends before its first picture" says 1 "1 failed" author "$work/short.mp4"
promise "a file without a video" says 1 "there is no video in this file" author "$work/sound.wav"
promise "a file that is none" says 1 '1 failed' author "$work/none.mp4"
promise "a missing file" says 1 'there is no such file' author "$work/missing.mp4"
promise "a picture that changes its size" says 1 'size changes from 320 x 288 to 352 x 288' author "$work/turns.ts"
promise "an output that is not ours stays" says 1 'is no copy that author made' \
  author --output "$work/foreign" "$work/in/wind.mp4"
promise "as it was" grep -q 'my notes' "$work/foreign/wind.haptic.ts"
promise "a full disk" says 1 '1 failed' \
  bash -c "ulimit -f 100; mkdir '$work/full'; '$haptic_track' author --output '$work/full' '$work/in/wind.mp4'"
promise "the other files go on" says 1 "1 written, 0 there already, 1 failed" \
  author --output "$work/foreign" "$work/missing.mp4" "$work/in/sea.mkv"
nothing_half_written() {
  ! find "$work" -name '*.part' | grep . && ! find "$work" -path "$work/full/*" | grep . &&
    ! find "$work" -name 'half.haptic*' -o -name 'short.haptic*' -o -name 'turns.haptic*' -o -name 'sound.haptic*' | grep .
}
promise "nothing half-written is left" nothing_half_written

# Pictures of it.
promise "a picture of the field" "$haptic_track" plot "$work/out/wind.haptic.ts" "$work/field.png"
promise "and one that moves" "$haptic_track" plot "$work/out/sea.haptic.mkv" "$work/field.gif"
# `has_arrows FILE COUNT`: so many pixels of its last picture have their color.
has_arrows() {
  ffmpeg -v error -i "$1" -update 1 -f image2 -c:v ppm "$work/last.ppm" -y
  ffmpeg -v error -i "$work/last.ppm" -f rawvideo -pix_fmt rgb24 - | od -An -v -tu1 -w3 |
    awk -v "least=$2" '$1 > 200 && $2 > 160 && $3 < 80 { n++ } END { print n + 0 " yellow pixels"; exit n < least }'
}
promise "it has arrows" has_arrows "$work/field.png" 1000
promise "so has the other" has_arrows "$work/field.gif" 1000
