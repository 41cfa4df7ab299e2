#!/bin/sh
# usage: cycles.sh DACRT_RUN
#
# Blender's Cycles, which traces single rays through instances, motion and filter functions, draws the
# same picture on Embree and on dacrt. (A path that a rounding sends elsewhere changes its pixel.)
set -eu
dacrt_run=$1
for program in blender idiff; do
  command -v "$program" >/dev/null || {
    echo "skipped: $program is missing (Debian: blender, openimageio-tools)"
    exit 77
  }
done

here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# Blender ends with 0 whatever becomes of the script.
draw() {
  picture=$1
  shift
  "$@" blender -b --factory-startup -P "$here/scene.py" -- \
    "$work/$picture" still,deforming,moving,crowd 256 4 1 >log 2>&1
  grep -q '^seconds ' log || {
    cat log
    exit 1
  }
}

draw embree.png env
# Cycles has a configuration string of its own, so that dacrt cannot be told to say its name.
draw dacrt.png env LD_DEBUG=libs "$dacrt_run"
grep -q 'calling init: .*/dacrt-embree3/libembree3.so.3$' log
idiff -warn 1 -fail 0.02 -failpercent 1 embree.png dacrt.png
