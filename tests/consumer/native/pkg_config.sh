#!/bin/sh
# usage: pkg_config.sh COMPILER PROGRAM.cc LIBRARY_DIR VERSION
#
# A program that takes its flags from `pkg-config dacrt` runs with libdacrt.
set -eu
compiler=$1 source=$2 library_dir=$3 version=$4

export PKG_CONFIG_PATH="$library_dir/pkgconfig"
found=$(pkg-config --modversion dacrt)
[ "$found" = "$version" ] || {
  echo "failed: pkg-config has dacrt $found, not $version" >&2
  exit 1
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck disable=SC2046  # flags are words
"$compiler" -std=c++20 "$source" -o "$work/program" $(pkg-config --cflags --libs dacrt)
LD_LIBRARY_PATH=$library_dir "$work/program"
