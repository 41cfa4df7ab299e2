#!/usr/bin/env bash
# usage: clang.sh SOURCE_DIR BUILD_DIR
#
# The other compiler builds the engine and the drop-in without a warning, and a tutorial draws on them what
# it draws on Embree. For the machine's own instruction set alone, because a build for all takes minutes:
# `cmake --preset clang` has that, and all tests.
set -euo pipefail
source_dir=$1 build=$2

if ! command -v clang++ >/dev/null; then
  echo "skipped: clang++ is missing (Debian: clang)"
  exit 77
fi
rm -rf "$build"
cmake -S "$source_dir" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_C_FLAGS=-Werror \
  -DCMAKE_CXX_FLAGS="-march=native -DHWY_COMPILE_ONLY_STATIC -Werror" -DCMAKE_UNITY_BUILD=ON \
  -DDACRT_SAMPLES=OFF -DDACRT_BENCHMARKS=OFF -DDACRT_MPI=OFF -DBUILD_TESTING=OFF
cmake --build "$build" --parallel 2
"$source_dir/tests/consumer/tutorial.sh" "$build/compat/dacrt-run" 5 viewer_stream \
  --triangle-plane -4 -1 -4 0 0 8 8 0 0 8 8 --triangle-sphere -1.5 0 0 0.7 20 \
  --quad-sphere 0 0 0 0.7 20 --grid-sphere 1.5 0 0 0.7 6 --point-sphere 0 1.5 0 0.7 0.05 20 \
  --pointlight 2 4 -3 60 60 60 --vp 0.13 2.07 -6.11 --vi 0.11 0.57 0 --fov 50
rm -rf "$build"
