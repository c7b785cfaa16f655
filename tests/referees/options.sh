#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Builds with every feature of meson_options.txt, then without each of them, and with each plugin alone; builds a second
# time only what differs, and nothing that a compiler cache has from build-tests/. No test runs. Installs once with other
# folders than the usual ones.
#
# Usage: tests/referees/options.sh
#
# Builds in build-options/.

source "$(dirname "$0")/../../pipelines/shared/common.sh"
source "$(dirname "$0")/support.sh"

no_options "$@"
cd "$root"
folder=$root/build-options
log=$folder/build.log
mkdir -p "$folder"
mapfile -t features < <(sed -nE "s/^option\('([^']*)', type: 'feature'.*/\1/p" meson_options.txt)
plugins=(vision device track)

# `state_of FEATURE [FEATURE STATE]...` prints the state that the arguments give to a feature; without one, enabled.
state_of() {
  local feature=$1
  shift
  while [ $# -gt 0 ] && [ "$1" != "$feature" ]; do
    shift 2
  done
  echo "${2:-enabled}"
}

# `build_with TEXT [FEATURE STATE]... [-- MESON-OPTION...]` builds with these features so, and all others enabled.
build_with() {
  local text=$1 feature states=() options=() start=$SECONDS
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    states+=("$1")
    shift
  done
  for feature in "${features[@]}"; do
    options+=("-D$feature=$(state_of "$feature" "${states[@]}")")
  done
  options+=(-Dgst-plugin-dir= -Dudev-dir= -Dhls-js= -Ddocumentation-uri= "${@:2}")
  printf -- '-- %s' "$text"
  if [ -f "$folder/build.ninja" ]; then
    # Meson 1.0 ignores some options beside --reconfigure.
    { meson configure "$folder" "${options[@]}" && meson setup --reconfigure "$folder"; } >"$log" 2>&1 || build_failed "$log"
  else
    meson setup "$folder" -Dunity=on -Dunity_size=6 -Dwerror=true -Ddebug=false "${options[@]}" >"$log" 2>&1 || build_failed "$log"
  fi
  ninja -C "$folder" >"$log" 2>&1 || build_failed "$log"
  for feature in "${plugins[@]}"; do
    is_built "$feature" "$(state_of "$feature" "${states[@]}")"
  done
  echo ": $((SECONDS - start)) s"
}

# `is_built PLUGIN STATE` fails if the build has the plugin although it is disabled, or the other way round.
is_built() {
  local state=disabled
  ! grep -q "^build [^ ]*/libgsthaptic$1\.so:" "$folder/build.ninja" || state=enabled
  [ $state = "$2" ] || fail "the option $1 is $2, and the build has it $state"
}

# Without help2man there is nothing to enable.
manuals=()
command -v help2man >/dev/null || manuals=(man-pages auto)

build_with "everything" "${manuals[@]}"
# What stands on the plugins of motion and force goes with them.
for feature in "${features[@]}"; do
  without=("$feature" disabled)
  [[ $feature != vision && $feature != device ]] || without+=(view disabled)
  [ "$feature" != device ] || without+=(evdev disabled)
  build_with "without $feature" "${without[@]}" "${manuals[@]}"
done
nothing=(view disabled evdev disabled benchmarks disabled man-pages disabled)
for plugin in "${plugins[@]}"; do
  others=("${nothing[@]}")
  for other in "${plugins[@]}"; do
    [ "$other" = "$plugin" ] || others+=("$other" disabled)
  done
  build_with "$plugin alone" "${others[@]}"
done
build_with "libspidar alone" "${nothing[@]}" vision disabled device disabled track disabled

build_with "other folders" tests disabled benchmarks disabled "${manuals[@]}" \
  -- -Dgst-plugin-dir=/elsewhere/plugins -Dudev-dir=/elsewhere/rules -Dhls-js=none -Ddocumentation-uri=https://example.org
rm -rf "$folder/installed"
meson install -C "$folder" --no-rebuild --quiet --destdir "$folder/installed" >"$log" 2>&1 || build_failed "$log"
for file in plugins/libgsthaptic{vision,device,track}.so rules/70-spidar.rules; do
  [ -f "$folder/installed/elsewhere/$file" ] || fail "$file is not where gst-plugin-dir or udev-dir says"
done
GST_PLUGIN_PATH_1_0=$folder/installed/elsewhere/plugins GST_REGISTRY=$folder/registry.bin \
  gst-inspect-1.0 roitracker 2>"$log" | grep 'Doc-uri.*https://example.org' >/dev/null ||
  fail "the plugins do not name what documentation-uri says"
[ -z "$(find "$folder/installed" -name hls.worker.js)" ] || fail "hls.js is installed although hls-js is none"
