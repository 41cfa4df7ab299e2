#!/bin/sh
# usage: command_line.sh COMPILER PROGRAM.c EMBREE_INCLUDE_DIR DACRT_LIBRARY_DIR
#
# A program that is compiled with -lembree3 and a library path uses dacrt.
set -eu
compiler=$1 source=$2 include_dir=$3 library_dir=$4

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$compiler" "$source" -o "$work/app" -I"$include_dir" \
  -L"$library_dir" -lembree3 -Wl,-rpath,"$library_dir"
"$work/app" dacrt
