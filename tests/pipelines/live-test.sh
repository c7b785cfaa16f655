#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Live over RTP: descriptions, encryption, two senders to one port, and a sender whose clock is faster.

source "$(dirname "$0")/support.sh"

unset DISPLAY WAYLAND_DISPLAY
use_elements rtponesender
clip "$work/up.mkv" 352 288 30 8 halves:0,-100,0,-100

# `to_receiver NAME [OPTION...] -- COMMAND...`: runs the command while receive.sh runs with these options. Its log is in
# $work/NAME.csv.
to_receiver() {
  local name=$1 options=() receiver status=0
  shift
  while [ "$1" != -- ]; do
    options+=("$1")
    shift
  done
  shift
  "$root/pipelines/receive.sh" "${options[@]}" -- device=sim "log-location=$work/$name.csv" >"$work/$name.out" 2>&1 &
  receiver=$!
  until grep -qs PLAYING "$work/$name.out"; do sleep 0.2; done
  "$@" || status=1
  kill -INT "$receiver"
  wait "$receiver" || status=1
  ! grep -A2 '^ERROR' "$work/$name.out" || status=1
  return "$status"
}

send() {
  timeout -k 10 100 "$root/pipelines/send.sh" "$@" >"$work/sender" 2>&1 || { tail -n 5 "$work/sender"; return 1; }
}

felt_up() {
  awk -F, 'NR > 1 && $9 > 0.4 { up++ } NR > 1 && $9 < -0.1 { down++ }
    END { print up + 0 " rows up, " down + 0 " down"; exit !(up > 500 && !down) }' "$work/$1.csv"
}

# No process has this secret among its words, which all users can read. It must not stand here as a word either.
hidden() {
  ! grep -qzF -f <(printf '%s\n' "$@") /proc/[0-9]*/cmdline "$work"/*.out "$work/sender" 2>/dev/null
}
# Only the description of an encrypted stream has a key. Only the user can read it, and it is hidden while both ends run.
key_is_hidden() {
  local key
  key=$(sed -n 's/^a=crypto.*inline://p' "$1") || return 1
  if [[ $1 != */srtp.sdp ]]; then
    [ -z "$key" ]
  else
    [ -n "$key" ] && [ "$(stat -c %a "$1")" = 600 ] &&
      hidden "$key" "$(base64 -d <<<"$key" | od -An -v -tx1 | tr -d ' \n')"
  fi
}
felt_and_hidden() {
  # shellcheck disable=SC2016 # $9 is awk's
  until awk -F, 'NR > 1 && $9 > 0.4 { found = 1 } END { exit !found }' "$work/$1.csv"; do sleep 0.1; done
  key_is_hidden "$work/$1.sdp" && wait "$2"
}

# `described NAME PORT OPTION...`: the receiver gets the sender's description and nothing else.
described() {
  local name=$1 port=$2
  shift 2
  send --port "$port" --sdp "$work/$name.sdp" "$@" "$work/up.mkv" &
  until [ -s "$work/$name.sdp" ]; do sleep 0.1; done
  to_receiver "$name" --sdp "$work/$name.sdp" -- felt_and_hidden "$name" $!
}

for options in '--track point' '--track hmpg' '--track field' '--srtp'; do
  name=${options##*-} name=${name#track } port=$(free_ports 10)
  read -r -a words <<<"$options"
  promise "send.sh $options: the receiver needs its description only" described "$name" "$port" "${words[@]}"
  promise "the force is felt" felt_up "$name"
done

# Of two senders to one port the first is felt. The other one, whose motion is down, is named.
two_senders() {
  local port=$1 first second
  clip "$work/down.mkv" 352 288 30 3 halves:0,100,0,100
  send --port "$port" "$work/up.mkv" &
  first=$!
  # shellcheck disable=SC2016 # $9 is awk's
  until awk -F, 'NR > 1 && $9 > 0.4 { found = 1 } END { exit !found }' "$work/two.csv"; do sleep 0.1; done
  # The second one takes the pointer and the reports at other ports.
  gst-launch-1.0 -q filesrc "location=$work/down.mkv" ! decodebin ! videoconvert ! clocksync ! roitracker ! velocityavg \
    ! hapticconvert ! meta/x-klv ! rtpklvpay pt=97 ! udpsink host=127.0.0.1 "port=$((port + 2))" sync=false &
  second=$!
  wait "$second"
  grep '^WARNING.*A second sender, 127.0.0.1' "$work/two.out" && wait "$first"
}

port=$(free_ports 10)
promise "a second sender to the same port is named" to_receiver two --port "$port" -- two_senders "$port"
promise "and not mixed in" felt_up two

# `over_srt WORDS COMMAND...`: a receiver of send-ts.sh with this passphrase, started by COMMAND; $port is that below.
over_srt() {
  local passphrase=$1
  shift
  echo "$passphrase" >"$work/words"
  "$@" "$root/pipelines/send-ts.sh" --receive --port "$port" --passphrase-file "$work/words" \
    -- device=sim "log-location=$work/srt.csv" >"$work/srt.out" 2>&1
}
# `explained WORDS TEXT`: this receiver fails. The sentence comes after its end.
explained() {
  ! over_srt "$1" timeout -k 10 60 || return 1
  for _ in {1..300}; do
    ! grep -F "$2" "$work/srt.out" || return 0
    sleep 0.1
  done
  cat "$work/srt.out"
  return 1
}
# The test source moves to the left.
felt_left() {
  awk -F, 'NR > 1 && $8 < -0.2 { left++ } NR > 1 && $8 > 0.1 { right++ }
    END { print left + 0 " rows to the left, " right + 0 " to the right"; exit !(left > 500 && !right && !$8 && !$9) }' "$work/srt.csv"
}

port=$(free_ports 10)
"$root/pipelines/send-ts.sh" --port "$port" --passphrase secret12345 --test-source >"$work/srt-sender" 2>&1 &
sender=$!
until grep -qs 'New clock' "$work/srt-sender"; do sleep 0.1; done
promise "SRT: a wrong passphrase is said in one sentence" explained another1234 'the passphrase is not that of the sender'
promise "SRT: with the right one it plays until Ctrl-C" over_srt secret12345 "$interrupt_at" "$work/srt.csv" 1 'time >= 5'
promise "SRT: the stream is felt, and at the end nothing" felt_left
kill -INT "$sender"
wait "$sender"
promise "SRT: that nobody sends is said too" explained secret12345 'nobody sends there, or the sender ended'

# A sender whose clock is 0.5 % faster: after 36 s it is as far ahead as one that is 100 ppm faster after 30 minutes.
# The receiver stands still four times, as on a busy machine.
mkdir "$work/bin"
printf '#!/bin/sh\nexec "%s" "$@"\n' "$DRIFTING_LAUNCH" >"$work/bin/gst-launch-1.0"
chmod +x "$work/bin/gst-launch-1.0"

sent_for() {
  local last
  last=$(tail -n 2 "$work/sent" 2>/dev/null | awk 'NF == 4 { last = $4 } END { print int(last) }') && [ "${last:-0}" -ge "$1" ]
}
drifting() {
  local sender second
  CLOCK_RATE=1.005 DRIFT_LOG=$work/sent PATH=$work/bin:$PATH send --port "$1" --test-source &
  sender=$!
  for second in 14 19 24 36; do
    until sent_for "$second"; do sleep 0.2; done
    # shellcheck disable=SC2154 # the receiver is that of to_receiver
    kill -STOP "$receiver" && sleep 0.4 && kill -CONT "$receiver"
  done
  pkill -INT -P "$sender" || true
  wait "$sender" || true
}

# For each frame: the running time at the receiver minus that at the sender, of the picture and of its motion. Before
# both streams have been reported about, which takes up to 6.2 s and the way (RFC 3550, section 6.3.1), they are as far
# apart as their first packets came.
in_step() {
  awk '
    FNR == NR { if (!(($2, $3) in sent)) sent[$2, $3] = $4; next }
    ($2, $3) in sent && !seen[$2, $3]++ {
      time = sent[$2, $3]
      frame = sprintf("%.3f", time)
      delay[$2, frame] = $4 - time
      if ($2 == "video" && time > 10) frames[++count] = frame
    }
    END {
      for (i = 1; i <= count; i++) {
        if (!(("track", frames[i]) in delay)) continue
        compared++
        drift = delay["video", frames[1]] - delay["video", frames[i]]
        apart = delay["video", frames[i]] - delay["track", frames[i]]
        if (apart < 0) apart = -apart
        if (apart > most) most = apart
      }
      printf "%d frames, clocks %.0f ms apart, picture and force %.1f ms at most\n", compared, drift * 1000, most * 1000
      exit !(compared > 600 && drift > 0.1 && most <= 0.02)
    }' "$work/sent" "$work/received"
}

port=$(free_ports 10)
export CLOCK_RATE=1 DRIFT_LOG=$work/received
PATH=$work/bin:$PATH promise "a sender with a faster clock is received" to_receiver drift --port "$port" -- drifting "$port"
promise "picture and force stay in step: 20 ms" in_step
