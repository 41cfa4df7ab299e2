#!/bin/sh
# usage: build.sh BUILD_DIR PACKAGES UNPACKED
#
# Makes the packages with cpack, in PACKAGES, and unpacks them all in UNPACKED.
set -eu
build=$1 packages=$2 unpacked=$3

for tool in dpkg-shlibdeps file; do
  if ! command -v $tool >/dev/null; then
    echo "skipped: $tool is missing (Debian: dpkg-dev, file)"
    exit 77
  fi
done
rm -rf "$packages" "$unpacked"
mkdir -p "$packages"
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$packages"
rm -rf "$packages/_CPack_Packages"
for package in "$packages"/*.deb; do
  dpkg-deb --extract "$package" "$unpacked"
done
