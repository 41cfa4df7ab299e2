#!/bin/sh
# usage: tutorial.sh DACRT_RUN COMPARE_PPM OUTLIERS PROGRAM [ARGUMENTS...]
#
# One of Debian's tutorial programs draws, unmodified and without a display, on Embree and on dacrt:
# single-step differences in under 100 pixels, of which OUTLIERS may differ by more.
set -eu
dacrt_run=$1 compare_ppm=$2 outliers=$3
shift 3

skip() {
  echo "skipped: $1 is missing (Debian: embree-tools)"
  exit 77
}
command -v "$1" >/dev/null || skip "$1"
for argument; do
  case $argument in
    /*) [ -e "$argument" ] || skip "$argument" ;;  # a scene of the package's documentation
  esac
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The programs ignore what they cannot open, and draw nothing: compare_ppm refuses such pictures.
"$@" --size 256 256 -o embree.ppm
# BIND_NOW: every function that the program imports must be there, called or not.
LD_BIND_NOW=1 DACRT_CONFIG=verbose=1 "$dacrt_run" "$@" --size 256 256 -o dacrt.ppm >log || {
  cat log
  exit 1
}
cat log
grep -q '^dacrt .* in place of Embree' log
"$compare_ppm" embree.ppm dacrt.ppm 99 "$outliers"
