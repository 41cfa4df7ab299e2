#!/bin/sh
# usage: named_functions.sh PAGE.md SOURCE_DIR
#
# Each row of the page's table names a function that is in the file that the row names. Whatever else the
# page names as code is in the source, too.
set -eu
page=$1 source=$2

sed -n 's/^| `\([^`]*\)` | \[[^]]*\](\([^)]*\)) |.*/\1 \2/p' "$page" | {
  rows=0
  while read -r name file; do
    rows=$((rows + 1))
    grep -q "\b${name##*::}\b" "$(dirname "$page")/$file" || {
      echo "failed: $name is not in $file" >&2
      exit 1
    }
  done
  [ "$rows" -gt 20 ] || {
    echo "failed: $rows rows are read" >&2
    exit 1
  }
}
for name in $(grep -o '`[A-Za-z][A-Za-z0-9:]*`' "$page" | tr -d '`' | sort -u); do
  grep -rqw "${name##*::}" "$source/compat" "$source/include" "$source/src" --include=*.h --include=*.cc || {
    echo "failed: $name is nowhere" >&2
    exit 1
  }
done
