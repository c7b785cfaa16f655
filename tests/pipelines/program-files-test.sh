#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The files that a desktop reads about feeling-wind.

source "$(dirname "$0")/support.sh"
data=$root/pipelines/program/data

promise "the desktop file starts the program with one film" grep -qx 'Exec=feeling-wind %u' "$data/feeling-wind.desktop"
# shellcheck disable=SC2016 # $0 is awk's
promise "each of its lines is a group or KEY=VALUE" \
  awk '!/^\[Desktop Entry\]$/ && !/^[A-Za-z]+=.+$/ { print; bad = 1 } END { exit bad }' "$data/feeling-wind.desktop"
command -v appstreamcli >/dev/null || skip "appstreamcli is not installed (package appstream)"
promise "the AppStream file is valid" appstreamcli validate --no-net "$data/org.feelingwind.FeelingWind.metainfo.xml"
