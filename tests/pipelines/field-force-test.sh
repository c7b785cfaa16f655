#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A hand feels the same from the coded field of the whole frame as from the tracker under it, at several places of each
# clip: the rms of the difference of both forces where either is felt, of a full force of 1 N, and how much of the time
# they could be told apart.
#
# From the environment: FIELD_CLIPS, a folder with other videos (*.mp4, *.avi, *.ts), at 15 places. There the tracker is
# also compared with itself a quarter of a cell (1/128 of the frame) to the right: where its own force changes by more
# than 5 %, the field need not agree. FIELD_COLUMNS: columns of the field. FIELD_METHOD and FIELD_AVERAGE: of the tracker;
# a cell of the field is measured with fast and model.

source "$(dirname "$0")/support.sh"
use_elements roitracker velocityavg motionfield hapticconvert
haptic_track=$build/gst-plugins/track/tools/haptic-track

# `track CLIP OUTPUT ELEMENTS...`
track() {
  local clip=$1 output=$2
  shift 2
  gst-launch-1.0 -q filesrc "location=$clip" ! decodebin 'caps=video/x-raw(ANY)' expose-all-streams=false ! videoconvert \
    ! "$@" ! hapticconvert ! meta/x-klv ! filesink "location=$output"
}

# `tracker CLIP X Y OUTPUT`
tracker() {
  track "$1" "$4" roitracker ${FIELD_METHOD:+"method=$FIELD_METHOD"} pointer-source=property "pointer-x=$2" "pointer-y=$3" \
    ! velocityavg ${FIELD_AVERAGE:+"average=$FIELD_AVERAGE"}
}

# `summary NAME ROWS`: of lines of JSON, one a place.
summary() {
  awk -F'[:,]' -v "name=$1" '
    { told += $2; felt += $4; rms += $6 }
    $2 > most_told { most_told = $2 }
    $6 > most { most = $6 }
    END {
      printf "%s: %.1f %% of the full force apart, %.1f at the worst of %d places; told apart in %.1f %% of the time, %.1f; felt in %.1f\n",
        name, 100 * rms / NR, 100 * most, NR, 100 * told / NR, 100 * most_told, 100 * felt / NR
      exit !(felt > 0)
    }' "$2"
}

agrees() {
  local clip=$1 name=${1##*/} x y
  track "$clip" "$work/field.klv" motionfield "field-columns=${FIELD_COLUMNS:-32}" || return 1
  rm -f "$work"/{field,beside}.rows
  for y in 0.167 0.5 0.833; do
    for x in $places; do
      tracker "$clip" "$x" "$y" "$work/place.klv" || return 1
      "$haptic_track" compare --json "$work/place.klv" "$work/field.klv" >>"$work/field.rows" || return 1
      [ -n "$others" ] || continue
      tracker "$clip" "$(awk -v "x=$x" 'BEGIN { print x + 1 / 128 }')" "$y" "$work/beside.klv" || return 1
      "$haptic_track" compare --json "$work/place.klv" "$work/beside.klv" >>"$work/beside.rows" || return 1
    done
  done
  [ -z "$others" ] || summary "$name, the tracker beside" "$work/beside.rows"
  summary "$name, $("$haptic_track" info "$work/field.klv" | awk '/size/ { print $2 }') kbit/s" "$work/field.rows" || return 1
  [ -n "$others" ] || cp "$work/field.rows" "$work/beside.rows" # the places of these clips are far from any border
  paste -d, "$work/field.rows" "$work/beside.rows" | awk -F'[:,]' -v "others=$others" '
    $6 > 0.05 && (!others || $(NF / 2 + 6) <= 0.05) { bad++ }
    END { if (bad) print bad " places are more than 5 % apart where the tracker agrees with itself"; exit bad > 0 }'
}

others=${FIELD_CLIPS:-} places='0.1 0.3 0.5 0.7 0.9'
if [ -z "$others" ]; then
  places='0.15 0.4 0.8'
  FIELD_CLIPS=$work/clips
  mkdir "$FIELD_CLIPS"
  clip "$FIELD_CLIPS/leaf.mp4" 640 360 30 2 leaf
  clip "$FIELD_CLIPS/halves.mp4" 640 360 30 2 halves:40,-60,-80,20
fi
shopt -s nullglob
clips=("$FIELD_CLIPS"/*.{mp4,avi,ts})
[ "${#clips[@]}" -gt 0 ] || skip "there are no videos in the folder '$FIELD_CLIPS'"
apart=()
for clip in "${clips[@]}"; do
  agrees "$clip" || apart+=("${clip##*/}")
done
promise "${#clips[@]} clips; apart: ${apart[*]:-none}" [ ${#apart[@]} = 0 ]
