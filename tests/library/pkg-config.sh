#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The C example as its user compiles it: by a C compiler with the flags of pkg-config, from the headers that are
# installed. Those of C++ are compiled, too.
# Usage: pkg-config.sh C-COMPILER C++-COMPILER LIBRARY BUILD
set -euo pipefail
compiler=$1 cxx=$2 library=$3 build=$4
tests=$(dirname "$0")
spidar=$tests/../../spidar
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT

ask() {
  pkg-config --define-variable=prefix="$prefix" "$@" "$build/meson-private/spidar.pc"
}

libraries=$(ask --variable=libdir) headers=$(ask --variable=includedir)/spidar
mkdir -p "$libraries" "$headers"
python3 -c 'import json, shutil, sys
for source, target in json.load(open(sys.argv[1])).items():
    if "/include/spidar/" in target:
        shutil.copy(source, sys.argv[2])' "$build/meson-info/intro-installed.json" "$headers"
cp "$library" "$libraries/libspidar.so.0"
ln -s libspidar.so.0 "$libraries/libspidar.so"

read -ra flags <<<"$(ask --cflags --libs)"
"$compiler" -std=c11 -Wall -Wextra -Wpedantic -Werror "$spidar/examples/hold.c" "${flags[@]}" -o "$prefix/hold"
# (The variable above is that of every package.)
read -ra flags <<<"$(ask --cflags) $(pkg-config --cflags eigen3)"
for header in "$headers"/*.hpp; do
  echo "#include <spidar/${header##*/}>"
done >"$prefix/all.cpp"
"$cxx" -std=c++20 -Wall -Wextra -Wpedantic -fsyntax-only "$prefix/all.cpp" "${flags[@]}"
LD_LIBRARY_PATH=$libraries "$tests/c-example.sh" "$prefix/hold"
