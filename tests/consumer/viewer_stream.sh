#!/bin/sh
# usage: viewer_stream.sh DACRT_RUN COMPARE_PPM
#
# Debian's viewer_stream draws the Cornell box, unmodified and without a display, on Embree and on
# dacrt: single-step differences in under 100 pixels.
set -eu
dacrt_run=$1 compare_ppm=$2
scene=/usr/share/doc/embree3/models/cornell_box.ecs

if ! command -v viewer_stream >/dev/null || [ ! -e "$scene" ]; then
  echo "skipped: viewer_stream or $scene is missing (Debian: embree-tools)"
  exit 77
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

viewer_stream -c "$scene" --size 256 256 -o embree.ppm
# BIND_NOW: every function that the program imports must be there, called or not.
LD_BIND_NOW=1 DACRT_CONFIG=verbose=1 "$dacrt_run" \
  viewer_stream -c "$scene" --size 256 256 -o dacrt.ppm >log
cat log
grep -q '^dacrt .* in place of Embree' log
"$compare_ppm" embree.ppm dacrt.ppm 99
