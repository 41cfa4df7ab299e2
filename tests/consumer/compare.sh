#!/bin/sh
# usage: compare.sh DACRT_COMPARE MESH...
#
# dacrt-compare says of one of Debian's tutorial programs, unmodified, and of each mesh, a file or a
# generated hall, whether to switch.
set -eu
compare=$1
shift

command -v viewer_stream >/dev/null || {
  echo "skipped: viewer_stream is missing (Debian: embree-tools)"
  exit 77
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

expect() {
  for text; do
    grep -qF "$text" log || {
      cat log
      echo "failed: there is no \"$text\"" >&2
      exit 1
    }
  done
}

# 64 x 64 pixels, in streams of 8 x 8.
"$compare" --repeat 1 viewer_stream --triangle-sphere 0 0 0 1 20 --size 64 64 -o picture.ppm >log
expect 'closest hit, streams to 64' ' 4 096' 'peak memory, MB' 'verdict: ' 'gains: ' 'loses: '
[ -s picture.ppm ]

for mesh; do
  "$compare" --repeat 1 --kind diffuse --rays 1 64K -- "$mesh" >log
  expect "$mesh: " 'commit, ms' 'first: Embree' 'verdict: ' 'gains: ' 'loses: '
done
