#!/bin/sh
# usage: library_path.sh COMPILER PROGRAM.c EMBREE_INCLUDE_DIR EMBREE_LIBRARY DACRT_LIBRARY_DIR
#
# A program that was linked with Embree uses dacrt once LD_LIBRARY_PATH says so.
set -eu
compiler=$1 source=$2 include_dir=$3 embree=$4 library_dir=$5

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$compiler" "$source" -o "$work/app" -I"$include_dir" "$embree"
"$work/app" embree
LD_LIBRARY_PATH=$library_dir "$work/app" dacrt
