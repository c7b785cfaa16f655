#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# haptic-track convert makes of a track what hapticarray makes of it.

source "$(dirname "$0")/support.sh"
haptic_track=$build/gst-plugins/track/tools/haptic-track

clip "$work/clip.mp4" 352 288 30 2 uniform:90,0
promise "a film is authored" "$haptic_track" author "$work/clip.mp4"
track=$work/clip.haptic.ts

promise "its track becomes sound" "$haptic_track" convert --layout ring-8 "$track" "$work/track.wav"
# The sound of 1 s as amplitude, the intensity of 1 s in the other file.
promise "and a pattern for telephones" "$haptic_track" convert "$track" "$work/track.ahap"
promise "both as strong as the force would be" python3 - "$work/track.wav" "$work/track.ahap" <<'END'
import array, json, math, sys
sound = open(sys.argv[1], "rb").read()
samples = array.array("f", sound[sound.index(b"data") + 8:][: 8 * 4 * 96000])
second = samples[8 * 48000 : 8 * 57600]
amplitude = math.sqrt(2 * sum(s * s for s in second) / 9600)
points = [(c["ParameterCurve"]["Time"] + p["Time"], p["ParameterValue"])
          for c in json.load(open(sys.argv[2]))["Pattern"] if "ParameterCurve" in c
          for p in c["ParameterCurve"]["ParameterCurveControlPoints"]]
before = max(p for p in points if p[0] <= 1.1)
after = min(p for p in points if p[0] > 1.1)
share = (1.1 - before[0]) / (after[0] - before[0])
intensity = (before[1] + share * (after[1] - before[1])) ** 2  # as amplitude
print(f"sound {amplitude:.3f}, pattern {intensity:.3f}")
wanted = 2 / math.pi * math.atan(0.01 * 90)  # equation 5 at 90 px/s
sys.exit(not (abs(intensity - amplitude) <= 0.05 * amplitude and abs(amplitude - wanted) <= 0.05 * wanted))
END

# The envelope of a swinging leaf: live, from the track of the same film, and as pattern.
clip "$work/leaf.mkv" 352 288 30 3 leaf
promise "a swinging film is authored" "$haptic_track" author "$work/leaf.mkv"
decoding "$work/leaf.mkv"
promise "and felt live" gst-launch-1.0 -q "${film[@]}" ! videoconvert ! motionfield \
  ! hapticarray layout=coils-2 ! audio/x-raw,rate=48000 ! filesink "location=$work/live.f32"
promise "its track becomes sound" "$haptic_track" convert --layout coils-2 "$work/leaf.haptic.mkv" "$work/leaf.wav"
promise "and a pattern" "$haptic_track" convert "$work/leaf.haptic.mkv" "$work/leaf.ahap"
promise "all with the same envelope" python3 "$root/tests/pipelines/envelopes.py" \
  "$work/live.f32" "$work/leaf.wav" "$work/leaf.ahap"

printf 'time,fx,fy,x,y\n0,0,0,-0.02,0.02\n5,0,0,-0.02,0.02\n' >"$work/hand.csv"
promise "along a recorded hand too" "$haptic_track" convert --hand "$work/hand.csv" "$track" "$work/hand.hmpg"
promise "as points" grep -q '^  samples' <("$haptic_track" info "$work/hand.hmpg")

cp "$root/gst-plugins/device/array/layouts/ring-8.ini" "$work/the \"ring\" \\of ! eight.ini"
promise "the path of a layout may have spaces, quotes and more" \
  "$haptic_track" convert --layout "$work/the \"ring\" \\of ! eight.ini" "$track" "$work/spaces.wav"
promise "and is read as the same layout" cmp "$work/track.wav" "$work/spaces.wav"

# `refuses TEXT FILE ARGUMENT...`: convert says so, and leaves nothing.
refuses() {
  local said status=0 text=$1 output=$2
  shift 2
  said=$("$haptic_track" convert "$@" "$output" 2>&1) || status=$?
  echo "status $status: $said"
  [ "$status" = 1 ] && grep -qF -- "$text" <<<"$said" && [ ! -e "$output" ] && [ ! -e "$output.part" ]
}
promise "a wrong layout is refused with its cure" \
  refuses 'There is no layout "jacket". Use back-3x4' "$work/none.wav" --layout jacket "$track"
promise "a wrong map too" refuses "--map knows stroke, field, point, not 'strike'" "$work/none.wav" --map strike "$track"
promise "and one that would be another element" \
  refuses "not 'stroke ! fakesink'" "$work/none.ahap" --map 'stroke ! fakesink' "$track"
promise "field needs a field" refuses '--map field needs motion fields' "$work/none.wav" --map field "$work/hand.hmpg"
promise "and alpha a number" refuses "--alpha needs a number from 0.0001 to 10, not '1 level=0'" "$work/none.wav" \
  --alpha '1 level=0' "$track"
