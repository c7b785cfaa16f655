#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Fetches hls.js for the player with npm, into build-web. The next `meson setup` finds it there and puts it beside
# the player.
#
# Usage: pipelines/web/fetch.sh [--tests]
#   --tests  also fetches what drives the browser of the tests

source "$(dirname "$0")/../shared/common.sh"

what=(--omit=dev)
case ${1:-} in
'') ;;
--tests) what=() ;;
--help | -h) show_help && exit ;;
*) fail "unknown option '$1'; see --help" ;;
esac

command -v npm >/dev/null || fail "npm is not installed; as root run: apt-get install npm"
folder=$root/build-web
mkdir -p "$folder" || fail "the folder '$folder' cannot be made; check the permissions of its parent"
cp "$root/pipelines/web/package.json" "$root/pipelines/web/package-lock.json" "$folder"
npm ci --prefix "$folder" --ignore-scripts --no-audit --no-fund --loglevel=error "${what[@]}" ||
  fail "npm could not fetch hls.js; check the network"
echo "$folder/node_modules/hls.js/dist"
