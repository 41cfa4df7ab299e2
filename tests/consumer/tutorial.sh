#!/bin/sh
# usage: tutorial.sh DACRT_RUN OUTLIERS PROGRAM [ARGUMENTS...]
#
# One of Debian's tutorial programs draws, unmodified and without a display, on Embree and on dacrt:
# single-step differences in under 100 pixels, of which OUTLIERS may differ by more.
set -eu
dacrt_run=$1 outliers=$2
shift 2

skip() {
  echo "skipped: $1 is missing (Debian: embree-tools, openimageio-tools)"
  exit 77
}
for program in "$1" idiff iinfo; do
  command -v "$program" >/dev/null || skip "$program"
done
for argument; do
  case $argument in
    /*) [ -e "$argument" ] || skip "$argument" ;;  # a scene of the package's documentation
  esac
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The programs ignore what they cannot open, and draw nothing.
"$@" --size 256 256 -o embree.ppm
iinfo --stats embree.ppm | grep -q 'Constant: No' || {
  echo "failed: the picture is empty"
  exit 1
}
# BIND_NOW: every function that the program imports must be there, called or not.
LD_BIND_NOW=1 DACRT_CONFIG=verbose=1 "$dacrt_run" "$@" --size 256 256 -o dacrt.ppm >log || {
  cat log
  exit 1
}
cat log
grep -q '^dacrt .* in place of Embree' log

# Fails if more than so many pixels differ by more than DIFFERENCE, of 1; idiff takes per cent.
compare() {
  idiff -warn 1 -fail "$2" -failpercent "$(awk "BEGIN {print 100 * ($1 + 0.5) / (256 * 256)}")" \
    embree.ppm dacrt.ppm
}
compare 99 0
compare "$outliers" 0.005  # a step is 1 / 255
