#!/bin/sh
# usage: dacrt_run.sh COMPILER PROGRAM.c EMBREE_INCLUDE_DIR EMBREE_LIBRARY DACRT_RUN
#
# dacrt-run runs a program that was linked with Embree on dacrt, with its arguments, its exit code
# and the library path that it had.
set -eu
compiler=$1 source=$2 include_dir=$3 embree=$4 dacrt_run=$5

fail() {
  echo "failed: $1" >&2
  exit 1
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$compiler" "$source" -o "$work/app" -I"$include_dir" "$embree"

"$work/app" embree
"$dacrt_run" "$work/app" dacrt
ln -s "$dacrt_run" "$work/link"
"$work/link" "$work/app" dacrt || fail "through a symbolic link"
(cd / && "$dacrt_run" "$work/app" dacrt) || fail "from another folder"

code=0
"$dacrt_run" sh -c 'exit 7' || code=$?
[ "$code" = 7 ] || fail "the program's exit code 7 became $code"
arguments=$("$dacrt_run" printf '<%s>' 'two words' '' '*')
[ "$arguments" = '<two words><><*>' ] || fail "the arguments became $arguments"
path=$(LD_LIBRARY_PATH=/before "$dacrt_run" sh -c 'echo "$LD_LIBRARY_PATH"')
case $path in
  /*:/before) ;;
  *) fail "the library path became $path" ;;
esac

# refused CODE TEXT [ARGUMENT]...: one line on the standard error.
refused() {
  expected=$1 text=$2
  shift 2
  code=0
  "$dacrt_run" "$@" >"$work/output" 2>"$work/errors" || code=$?
  [ "$code" = "$expected" ] || fail "with '$*' the exit code is $code"
  [ ! -s "$work/output" ] && [ "$(wc -l <"$work/errors")" = 1 ] || fail "with '$*' it is not one line"
  grep -qF -e "$text" "$work/errors" || fail "with '$*' there is no '$text'"
}
refused 2 'usage: dacrt-run PROGRAM'
refused 2 '--quick: there is no such option; there is --help' --quick
refused 127 no_such_program no_such_program
refused 126 "$source" "$source"
"$dacrt_run" --help | grep -q '^usage: dacrt-run PROGRAM' || fail "there is no --help"
