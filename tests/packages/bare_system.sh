#!/bin/sh
# usage: bare_system.sh PACKAGES CONSUMERS MESH...
#
# What the README promises of the packages, in a bare Debian that mmdebstrap makes from the archive: apt
# installs them with what they need, and nothing is left when they are removed; programs are built there
# against libdacrt and the drop-in; Debian's viewer_stream draws through dacrt-run; dacrt-compare has a
# verdict on it and on each MESH, a file or a generated hall. Takes about a minute, most of it for the
# compilers and the programs that are installed.
set -eu
packages=$1 consumers=$2
shift 2

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
cp -r "$consumers/project" "$consumers/native" "$consumers/compare.sh" "$work/dacrt"
meshes=
for mesh; do
  if [ -e "$mesh" ]; then
    cp "$mesh" "$work/dacrt"
    mesh=/dacrt/$(basename "$mesh")
  fi
  meshes="$meshes $mesh"
done

cat >"$work/dacrt/inside.sh" <<'INSIDE'
set -eu
cd /dacrt
fail() {
  echo "failed: $1"
  exit 1
}
install() {
  apt-get install --yes --no-install-recommends "$@"
}
before=$(dpkg-query --show | sort)

echo "== Installing and removing"
install ./dacrt-embree3_*.deb
if dpkg-query --show --showformat '${db:Status-Status}\n' 'libembree*' 2>/dev/null | grep -x installed; then
  fail "Embree came with them"
fi
if ldconfig -p | grep libembree3; then
  fail "the linker finds the drop-in"
fi
install ./*.deb
apt-get purge --yes $(for package in *.deb; do echo "${package%%_*}"; done)
apt-get autoremove --purge --yes
[ "$before" = "$(dpkg-query --show | sort)" ] || fail "packages stay"
left=$(find / -xdev -path /proc -prune -o -path /dacrt -prune -o -name '*dacrt*' -print)
[ -z "$left" ] || fail "left: $left"

echo "== Building"
install ./libdacrt*.deb ./dacrt-embree3_*.deb cmake g++ make pkg-config embree-tools libembree-dev
version=$(dpkg-query --show --showformat '${Version}' libdacrt0)
cmake -S native -B native/build -DEXPECTED_VERSION="$version"
cmake --build native/build
native/build/native
native/pkg_config.sh c++ native/native.cc "$(dirname "$(find /usr/lib -name 'libdacrt.so')")" "$version"
cmake -S project -B project/build \
  -Dembree_DIR="$(dirname "$(find /usr/lib -path '*dacrt-embree3/*' -name embree-config.cmake)")"
cmake --build project/build
project/build/app dacrt
cc project/app.c -o embree_program -lembree3
./embree_program embree
dacrt-run ./embree_program dacrt

echo "== Drawing"
DACRT_CONFIG=verbose=1 dacrt-run viewer_stream --triangle-sphere 0 0 0 1 20 --size 64 64 -o picture.ppm >log
cat log
grep -q '^dacrt .* in place of Embree' log
colours=$(tail -c 12288 picture.ppm | od -An -v -tx1 -w3 | sort -u | wc -l)
[ "$colours" -gt 50 ] || fail "the picture has $colours colours"

echo "== Comparing"
./compare.sh dacrt-compare "$@"

echo "== Without Embree"
apt-get purge --yes libembree3-3
dacrt-run ./embree_program dacrt
echo "== All is well"
INSIDE

. /etc/os-release
: >"$work/log"
mmdebstrap --quiet --variant=apt --format=null --skip=check/empty \
  --dpkgopt=force-unsafe-io --aptopt='Acquire::Retries "3"' \
  --customize-hook="echo bare >>'$work/log'" \
  --customize-hook="cp -r '$work/dacrt' \"\$1/dacrt\"" \
  --customize-hook="chroot \"\$1\" sh /dacrt/inside.sh $meshes >>'$work/log' 2>&1" \
  "$VERSION_CODENAME" /dev/null || true
cat "$work/log"
grep -q '^bare$' "$work/log" || skip "the bare system could not be made"
grep -q '^== All is well$' "$work/log"
