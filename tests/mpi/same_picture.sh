#!/bin/sh
# usage: same_picture.sh MPIRUN DACRT_RUN PICTURE PROGRAM [ARGUMENTS...]
#
# A program draws the same picture, to the last bit, in one process and with three ranks of
# dacrt_mpi=replicate. PICTURE is the file that it writes.
set -eu
mpirun=$1 dacrt_run=$2 picture=$3
shift 3

if ! command -v "$1" >/dev/null; then
  echo "skipped: $1 is missing (Debian: embree-tools)"
  exit 77
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$dacrt_run" "$@" >/dev/null
mv "$picture" one
DACRT_CONFIG=verbose=1,dacrt_mpi_least_rays=1 \
  "$mpirun" --oversubscribe -n 3 "$dacrt_run" "$@" >log 2>&1 || {
  cat log
  exit 1
}
grep 'dacrt: rank 0 of 3, calls of 1 rays and more are shared' log || {
  cat log
  exit 1
}
cmp one "$picture"
