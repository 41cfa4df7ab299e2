#!/bin/sh
# usage: contents.sh PACKAGES UNPACKED SOURCE_DIR
#
# What is in the packages, and what is not: the drop-in stands in nobody's way, it needs no MPI, each
# program has its page, and nothing names the folders in which it was made.
set -eu
packages=$1 unpacked=$2 source_dir=$3

fail() {
  echo "failed: $1" >&2
  exit 1
}
files_of() {
  dpkg-deb --contents "$packages/$1"_*.deb | awk '{print $6}' | sed 's|^\./|/|'
}
needs_of() {
  dpkg-deb --field "$packages/$1"_*.deb Depends
}

for package in libdacrt0 libdacrt-dev; do
  files_of $package | grep -q '/embree' && fail "$package has a file of the drop-in's"
done
files_of libdacrt0 | grep -q '/libdacrt\.so\.0$' || fail "libdacrt0 has no libdacrt.so.0"
files_of libdacrt-dev | grep -q '/dacrt/dacrt\.h$' || fail "libdacrt-dev has no dacrt.h"
needs_of libdacrt0 | grep -q 'libtbb.*libhwy\|libhwy.*libtbb' || fail "libdacrt0 does not name its libraries"
needs_of libdacrt-dev | grep -q 'libdacrt0 (= ' || fail "libdacrt-dev takes any libdacrt0"

for package in "$packages"/dacrt-embree3*.deb; do
  package=$(basename "$package")
  package=${package%%_*}
  files_of "$package" | grep '\.so' | grep -v '/dacrt-embree3/' &&
    fail "$package has a library in the linker's way"
done
if [ -e "$packages"/dacrt-embree3_*.deb ]; then
  files_of dacrt-embree3 | grep -q '/dacrt-embree3/libembree3\.so\.3$' || fail "no libembree3.so.3"
  needs_of dacrt-embree3 | grep 'mpi\|libembree' && fail "dacrt-embree3 needs too much"
fi

for package in "$packages"/*.deb; do
  package=$(basename "$package")
  package=${package%%_*}
  for program in $(files_of "$package" | sed -n 's|^/usr/bin/\(..*\)|\1|p'); do
    files_of "$package" | grep -q "/man1/$program\.1\.gz$" || fail "$program has no page"
  done
done

named=$(grep -rlF "$source_dir" "$unpacked" || true)
[ -z "$named" ] || fail "$source_dir is named in $named"
