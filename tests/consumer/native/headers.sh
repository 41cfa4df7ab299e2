#!/bin/sh
# usage: headers.sh COMPILER INCLUDE_DIR
#
# Each installed header compiles alone, without a warning, and names no file that is not installed.
set -eu
compiler=$1 include_dir=$2

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for header in "$include_dir"/dacrt/*.h; do
  echo "#include \"$header\"" >"$work/header.cc"
  "$compiler" -std=c++20 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I"$include_dir" \
    "$work/header.cc"
  for named in $(grep -o '[a-z_/]*[a-z_]\.\(h\|cc\)\>' "$header" | sort -u); do
    [ -e "$include_dir/$named" ] || [ -e "$include_dir/dacrt/$named" ] || [ "$named" = mpi.h ] || {
      echo "failed: $header names $named, which is not installed" >&2
      exit 1
    }
  done
done
