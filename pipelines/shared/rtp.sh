# SPDX-License-Identifier: LGPL-2.1-or-later
# shellcheck shell=bash disable=SC2034,SC2154 # its variables are shared with the scripts that source it
# RTP as send.sh and receive.sh use it; send-ts.sh checks its port by it. To be sourced after common.sh.

# The caps of each payload. Its type is a number that the sender chooses.
rtp_video=application/x-rtp,media=video,clock-rate=90000,encoding-name=H264,payload=96,rtcp-fb-nack-pli=true,rtcp-fb-ccm-fir=true
rtp_klv=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M,payload=97,rtcp-fb-ccm-fir=true
rtp_hmpg=application/x-rtp,media=haptics,clock-rate=8000,encoding-name=HMPG,payload=115,rtcp-fb-ccm-fir=true

need_rtp_port() {
  if ! [[ $1 =~ ^[1-9][0-9]{0,4}$ ]] || [ $(($1 % 2)) = 1 ] || [ "$1" -gt 65526 ]; then
    fail "--port needs an even number up to 65526, not '$1'"
  fi
}

# Sets $secret to $key (base64) as 60 hexadecimal digits.
hide_key() {
  secret=$(base64 -d <<<"$key" | od -An -v -tx1 | tr -d ' \n')
}

# `srtp_caps CAPS SSRC`: the caps of the same payload, encrypted with $secret.
srtp_caps() {
  echo "${1/x-r/x-sr},ssrc=(uint)$2,srtp-key=(buffer)@secret@,srtp-cipher=aes-128-icm" \
    "srtp-auth=hmac-sha1-80,srtcp-cipher=aes-128-icm,srtcp-auth=hmac-sha1-80" | tr ' ' ,
}

# `sdp_media NAME PORT TYPE ENCODING SSRC [ATTRIBUTE...]`: one part of write_sdp.
sdp_media() {
  local profile=AVPF ssrc=$5
  [ -z "$key" ] || profile=SAVPF
  printf '%s\n' "m=$1 $2 RTP/$profile $3" "a=rtpmap:$3 $4" "${@:6}"
  [ -z "$key" ] || printf '%s\n' "a=ssrc:$ssrc cname:feeling-wind" \
    "a=crypto:1 AES_CM_128_HMAC_SHA1_80 inline:$key"
}

# Prints the description of what send.sh sends ($track, $port, $host, $key) and of the pointer that it takes. It
# is from the sender's view (RFC 8866; RFC 9993 for haptics, RFC 6597 for KLV, RFC 4568 for the key).
write_sdp() {
  local family=IP4 feedback=a=rtcp-fb:96
  [[ $host != *:* ]] || family=IP6
  printf '%s\n' v=0 "o=- $(date +%s) 1 IN $family $host" "s=Feeling Wind" "c=IN $family $host" "t=0 0"
  sdp_media video "$port" 96 H264/90000 "$video_ssrc" a=fmtp:96\ packetization-mode=1 \
    "$feedback nack pli" "$feedback ccm fir" a=sendonly
  if [ "$track" = hmpg ]; then
    sdp_media haptics $((port + 2)) 115 hmpg/8000 "$track_ssrc" \
      "a=fmtp:115 hmpg-ver=2023;hmpg-profile=main;hmpg-lvl=1;hmpg-modalities=Force" "a=rtcp-fb:115 ccm fir" a=sendonly
  else
    sdp_media application $((port + 2)) 97 smpte336m/90000 "$track_ssrc" "a=rtcp-fb:97 ccm fir" a=sendonly
  fi
  sdp_media application $((port + 4)) 97 smpte336m/90000 "$pointer_ssrc" a=recvonly
}

# `read_sdp FILE`: sets $port, $track, $key and the SSRCs from what write_sdp wrote. Ports other than those are refused.
read_sdp() {
  local line name='' number='' encoding ssrc='' video='' crypto=AES_CM_128_HMAC_SHA1_80
  need_file "$1"
  track='' key=''
  while IFS= read -r line || [ -n "$line" ]; do
    line=${line%$'\r'}
    if [[ $line =~ ^m=([a-z]+)\ ([1-9][0-9]{0,4})\ RTP/S?AVPF?\ ([0-9]{1,3})$ ]]; then
      name=${BASH_REMATCH[1]} number=${BASH_REMATCH[2]}
      [ "$name" != video ] || { video=yes port=$number; }
    elif [[ $line =~ ^a=rtpmap:[0-9]+\ ([A-Za-z0-9]+/[0-9]+) ]]; then
      encoding=${BASH_REMATCH[1],,}
      case $name/$encoding in
      video/h264/90000) ;;
      haptics/hmpg/8000) track=hmpg ;;
      application/smpte336m/90000) track=${track:-point} ;;
      *) fail "'$1' describes $name as $encoding, which receive.sh does not know; write it with send.sh --sdp" ;;
      esac
    elif [[ $line =~ ^a=ssrc:([0-9]{1,10})\  ]]; then
      ssrc=${BASH_REMATCH[1]}
      [ "$name" != video ] || video_ssrc=$ssrc
      [ "$number" != $((port + 2)) ] || track_ssrc=$ssrc
      [ "$number" != $((port + 4)) ] || pointer_ssrc=$ssrc
    elif [[ $line =~ ^a=crypto:1\ $crypto\ inline:([A-Za-z0-9+/]{40})$ ]]; then
      key=${BASH_REMATCH[1]}
    fi
  done <"$1"
  if [ -z "$video" ] || [ -z "$track" ]; then
    fail "'$1' is not a description of a video with a haptic track; write it with send.sh --sdp"
  elif [ -n "$key" ] && [ -z "${video_ssrc:+${track_ssrc:+${pointer_ssrc:+all}}}" ]; then
    fail "'$1' has a key, but not the SSRC of each stream; write it with send.sh --sdp"
  fi
}
