#!/bin/sh
# usage: bare_system.sh PACKAGES COMPILER CONSUMERS EMBREE UNPACKED_LIBRARY_DIR [--build]
#
# In a bare Debian that mmdebstrap makes from the archive: apt installs the packages with what they
# need; programs that were built here, with the consumer tests' sources, run there, on dacrt without
# Embree; nothing is left when the packages are removed.
#
# --build: also what takes minutes, because its packages are large: the programs are built there, and
# Debian's viewer_stream draws through dacrt-run.
set -eu
packages=$1 compiler=$2 consumers=$3 embree=$4 library_dir=$5 build=${6-}

skip() {
  echo "skipped: $1"
  exit 77
}
command -v mmdebstrap >/dev/null || skip "mmdebstrap is missing (Debian: mmdebstrap)"
[ "$(id -u)" = 0 ] || skip "only root can enter the bare system"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/dacrt"
cp "$packages"/*.deb "$work/dacrt"
cp -r "$consumers/project" "$consumers/native" "$work/dacrt"
"$compiler" -x c "$consumers/project/app.c" -x none -o "$work/dacrt/embree_program" "$embree"
"$compiler" -std=c++20 "$consumers/native/native.cc" -o "$work/dacrt/native_program" \
  -I"${library_dir%/usr/*}/usr/include" -L"$library_dir" -ldacrt

cat >"$work/dacrt/inside.sh" <<'INSIDE'
set -eu
cd /dacrt
before=$(dpkg-query --show | sort)

echo "== Installing"
apt-get install --yes --no-install-recommends ./libdacrt0_*.deb ./dacrt-embree3_*.deb
if dpkg-query --show --showformat '${db:Status-Status}\n' 'libembree*' 2>/dev/null | grep -x installed; then
  echo "failed: Embree came with them"
  exit 1
fi
./native_program
dacrt-run ./embree_program dacrt
if ldconfig -p | grep libembree3; then
  echo "failed: the linker finds the drop-in"
  exit 1
fi
apt-get install --yes --no-install-recommends ./*.deb

if [ "${1-}" = --build ]; then
  echo "== Building and drawing"
  apt-get install --yes --no-install-recommends cmake g++ make pkg-config embree-tools libembree-dev
  version=$(dpkg-query --show --showformat '${Version}' libdacrt0)
  cmake -S native -B native/build -DEXPECTED_VERSION="$version"
  cmake --build native/build
  native/build/native
  native/pkg_config.sh c++ native/native.cc "$(dirname "$(find /usr/lib -name 'libdacrt.so')")" "$version"
  cmake -S project -B project/build \
    -Dembree_DIR="$(dirname "$(find /usr/lib -path '*dacrt-embree3/*' -name embree-config.cmake)")"
  cmake --build project/build
  project/build/app dacrt
  DACRT_CONFIG=verbose=1 dacrt-run viewer_stream --triangle-sphere 0 0 0 1 20 --size 64 64 -o picture.ppm
  [ "$(wc -c <picture.ppm)" -gt 12288 ]
fi

echo "== Removing"
apt-get purge --yes $(for package in *.deb; do echo "${package%%_*}"; done)
if [ "${1-}" != --build ]; then
  apt-get autoremove --purge --yes
  [ "$before" = "$(dpkg-query --show | sort)" ] || { echo "failed: packages stay"; exit 1; }
fi
left=$(find / -xdev -path /proc -prune -o -path /dacrt -prune -o -name '*dacrt*' -print)
[ -z "$left" ] || { echo "failed: left: $left"; exit 1; }
echo "== All is well"
INSIDE

. /etc/os-release
: >"$work/log"
mmdebstrap --quiet --variant=apt --format=null --skip=check/empty \
  --dpkgopt=force-unsafe-io --aptopt='Acquire::Retries "3"' \
  --customize-hook="echo bare >>'$work/log'" \
  --customize-hook="cp -r '$work/dacrt' \"\$1/dacrt\"" \
  --customize-hook="chroot \"\$1\" sh /dacrt/inside.sh $build >>'$work/log' 2>&1" \
  "$VERSION_CODENAME" /dev/null || true
cat "$work/log"
grep -q '^bare$' "$work/log" || skip "the bare system could not be made"
grep -q '^== All is well$' "$work/log"
