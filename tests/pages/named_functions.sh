#!/bin/sh
# usage: named_functions.sh PAGE.md
#
# Each row of the page's table names a function that is in the file that the row names.
set -eu
page=$1

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
