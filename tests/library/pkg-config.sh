#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The C example as its user compiles it: by a C compiler with the flags of pkg-config, from the installed headers.
# Usage: pkg-config.sh COMPILER LIBRARY BUILD
set -euo pipefail
compiler=$1 library=$2 build=$3
tests=$(dirname "$0")
spidar=$tests/../../spidar
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT

ask() {
  pkg-config --define-variable=prefix="$prefix" "$@" "$build/meson-private/spidar.pc"
}

libraries=$(ask --variable=libdir) headers=$(ask --variable=includedir)/spidar
mkdir -p "$libraries" "$headers"
cp "$spidar"/include/spidar/*.h* "$build/spidar/include/spidar/version.h" "$headers"
rm -f "$headers/version.h.in"
cp "$library" "$libraries/libspidar.so.0"
ln -s libspidar.so.0 "$libraries/libspidar.so"

read -ra flags <<<"$(ask --cflags --libs)"
"$compiler" -std=c11 -Wall -Wextra -Wpedantic -Werror "$spidar/examples/hold.c" "${flags[@]}" -o "$prefix/hold"
LD_LIBRARY_PATH=$libraries "$tests/c-example.sh" "$prefix/hold"
