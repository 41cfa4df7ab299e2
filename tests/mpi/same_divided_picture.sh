#!/bin/sh
# usage: same_divided_picture.sh MPIRUN DIVIDED_AMBIENT_OCCLUSION
#
# Three ranks, each with a slice of the hall, draw what one draws that has all of it. One of them says
# how the program is called.
set -eu
mpirun=$1 program=$2

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for ranks in 1 3; do
  "$mpirun" --oversubscribe -n $ranks "$program" --triangles 75000 --width 160 --height 90 \
    --ao-samples 8 --output "$work/$ranks.png"
done
cmp "$work/1.png" "$work/3.png"

"$mpirun" --oversubscribe -n 3 "$program" --help >"$work/help"
[ "$(grep -c -e --triangles "$work/help")" = 1 ]
code=0
"$mpirun" --oversubscribe -n 3 "$program" --triangle 5 2>"$work/errors" || code=$?
[ $code = 2 ]
[ "$(grep -c -e '--triangle' "$work/errors")" = 1 ]
