#!/bin/sh
# usage: once_more.sh MPIRUN [ARGUMENTS...]
#
# Runs a job that loses a rank, and once more if it does not come back: OpenMPI 4.1's mpirun has been seen
# to say "PMIX ERROR: BAD-PARAM" then, when the test had ended well, and to stay. A job of ours that hangs
# does so twice.
seconds=70
timeout -k 2 $seconds "$@"
code=$?
[ $code -eq 124 ] || exit $code
timeout -k 2 $seconds "$@"
code=$?
[ $code -ne 124 ] || echo "FAILED: no end after $seconds seconds, twice"
exit $code
