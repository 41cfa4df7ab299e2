#!/bin/sh
# usage: options.sh PAGE PROGRAM
#
# The program's page for man has the options that its --help has, and no others.
set -eu
page=$1 program=$2

options() {
  grep -oE '^ *(-[a-z],)?--[a-z-]+' | grep -oE -e '--[a-z-]+' | sort -u
}
of_page=$(sed -n '/^\.SH OPTIONS/,/^\.SH [^O]/s/^\.BI\{0,1\} \\-\\-/--/p' "$page" | sed 's/\\-/-/g' | options)
of_program=$("$program" --help | options)
[ -n "$of_program" ]
[ "$of_page" = "$of_program" ] || {
  echo "failed: $page has" $of_page "and $program has" $of_program >&2
  exit 1
}
