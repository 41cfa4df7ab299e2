#!/usr/bin/env bash
# usage: build_parts.sh SOURCE_DIR COMPILED_BUILD_DIR BUILD_DIR FILE... !FILE... -- CMAKE_OPTION...
#
# Configures and builds dacrt with these options in an empty BUILD_DIR. Succeeds if each FILE is made,
# and none of those behind a "!".
set -euo pipefail
source_dir=$1 compiled=$2 build=$3
shift 3
files=()
while [[ $1 != -- ]]; do
  files+=("$1")
  shift
done
shift

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$build"
launcher="$here/reuse_object.sh;$compiled;$build"
cmake -S "$source_dir" -B "$build" "-DCMAKE_CXX_COMPILER_LAUNCHER=$launcher" \
  "-DCMAKE_C_COMPILER_LAUNCHER=$launcher" "$@"
cmake --build "$build" --parallel 2

for file in "${files[@]}"; do
  if [[ $file == !* ]]; then
    [[ ! -e $build/${file#!} ]] || { echo "failed: ${file#!} was made"; exit 1; }
  else
    [[ -e $build/$file ]] || { echo "failed: $file was not made"; exit 1; }
  fi
done
rm -rf "$build"
