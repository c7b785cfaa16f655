#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Builds the pages as a site that can be published, with a film to be felt on its first page.
#
# The film is the one of the demonstration, 640 px wide; it is drawn, and kept nowhere but in the site. Packages:
# mkdocs-material ffmpeg. Without this script, `mkdocs build` builds the same pages without a film.
#
# Usage: pipelines/web/site.sh [FOLDER]
#   FOLDER  where the site goes (build-site); what is in it is replaced

source "$(dirname "$0")/../shared/common.sh"
source "$(dirname "$0")/../shared/packages.sh"

read_options '' "$@"
[ ${#inputs[@]} -le 1 ] || fail "there is more than one folder; give one, see --help"
folder=$(realpath -m "${inputs[0]:-$root/build-site}")
for program in mkdocs ffmpeg; do
  command -v $program >/dev/null || fail "$program is not installed; as root run: apt-get install mkdocs-material ffmpeg"
done
find_plugins
video=$(wind_film)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

ffmpeg -v error -y -i "$video" -vf scale=640:-2 -c:v libx264 -crf 27 -preset slow -c:a copy -movflags +faststart \
  "$work/film.mp4" </dev/null || fail "ffmpeg could not make the film smaller; make room on the disk"
ffmpeg -v error -y -ss 9 -i "$work/film.mp4" -frames:v 1 -c:v libwebp -quality 60 "$work/poster.webp" </dev/null
[ ! -d "$build/pipelines/web" ] || export FEELING_WIND_WEB=$build/pipelines/web
haptic_track package --single --output "$work/film" "$work/film.mp4" >/dev/null ||
  fail "haptic-track could not package the film; read its message above"
mv "$work/poster.webp" "$work/film"
FEELING_WIND_FILM=$work/film mkdocs build --quiet --strict --config-file "$root/mkdocs.yml" --site-dir "$folder" ||
  fail "mkdocs could not build the site; read its message above"
echo "$folder/index.html"
