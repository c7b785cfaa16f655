#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The shared library exports the C API and what spidar:: marks, in their versions, and nothing else.
# Usage: symbols.sh LIBRARY NM READELF
set -euo pipefail
library=$1 nm=$2 readelf=$3
failed=0

fail() {
  echo "FAILED: $*"
  failed=1
}

exported=$("$nm" --dynamic --defined-only --demangle "$library" | cut -d' ' -f3-)

others=$(grep -vE '^(spidar_[a-z_]+@@SPIDAR_0|((typeinfo|typeinfo name|vtable) for )?spidar::.*@@SPIDAR_CXX_0\.1|SPIDAR_[A-Z_0-9.]+(@@.*)?)$' \
  <<<"$exported") || true
[ -z "$others" ] || fail "these are exported without need: $others"

hidden=$(grep -E '::(Implementation|State)::' <<<"$exported") || true
[ -z "$hidden" ] || fail "these belong to the implementation: $hidden"

# The C functions that the header declares.
header=$(dirname "$0")/../../spidar/include/spidar/spidar.h
declared=$(grep -oE '\bspidar_[a-z_]+\(' <(grep -A1 '^SPIDAR_C_API' "$header") | tr -d '(' | sort -u)
got=$(grep -oE '^spidar_[a-z_]+' <<<"$exported" | sort -u)
[ "$declared" = "$got" ] || fail "declared and exported C functions differ: $(diff <(echo "$declared") <(echo "$got"))"

for name in 'spidar::load_geometry' 'spidar::Device::exchange' 'typeinfo for spidar::Error' 'vtable for spidar::Device'; do
  grep -qF "$name" <<<"$exported" || fail "$name is not exported"
done

"$readelf" -d "$library" | grep -qF 'soname: [libspidar.so.0]' || fail "the soname is not libspidar.so.0"
[ "$failed" = 0 ]
