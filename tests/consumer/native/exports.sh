#!/bin/sh
# usage: exports.sh LIBDACRT
#
# libdacrt exports what is dacrt's public API, and nothing of its inside or of other libraries.
set -eu
library=$1

exports=$(nm --dynamic --defined-only --demangle "$library" | cut -d' ' -f3-)
echo "$exports" | grep -q '^dacrt::Scene::Trace(' || {
  echo "failed: Scene::Trace is not exported" >&2
  exit 1
}
inside=$(echo "$exports" | grep -v '^\(\(typeinfo\|typeinfo name\|vtable\) for \)\?dacrt::' || true)
inside=$inside$(echo "$exports" | grep 'Implementation::\|::N_' || true)
[ -z "$inside" ] || {
  echo "failed: exported, too:" >&2
  echo "$inside" >&2
  exit 1
}
