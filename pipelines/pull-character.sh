#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# A character stands in the film as a layer of its own. A hand over it that presses holds it on a leash: the character
# follows, and a spring pulls the hand back. Let go by lifting, and it returns. The film goes on as it was made.
#
# Usage: pipelines/pull-character.sh FILE [--output OUT.mkv] [--story OUT.raw] [-- OPTION=VALUE...]
#   FILE      a video file
#   --output  writes a film instead of opening a window
#   --story   writes the film without the character, as raw I420 frames
#   What follows -- goes to hapticsink, for example device=usb. Ctrl-C stops.
#
# Example:
#   pipelines/pull-character.sh in.mp4 --output pulled.mkv -- device=sim

source "$(dirname "$0")/shared/common.sh"

case ${1:---help} in --help | -h) show_help && exit ;; esac
find_plugins
need_packaged_elements compositor
exec "$root/pipelines/shared/pull-character.py" "$@"
