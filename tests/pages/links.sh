#!/bin/sh
# usage: links.sh PAGE.md...
#
# What the pages link to is there.
set -eu

failed=0
for page; do
  for link in $(grep -o ']([^)]*)' "$page" | sed 's/^](\([^)#]*\).*/\1/' | grep -v '://'); do
    [ -e "$(dirname "$page")/$link" ] || {
      echo "failed: $page links to $link, which is not there" >&2
      failed=1
    }
  done
done
exit $failed
