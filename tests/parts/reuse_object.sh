#!/usr/bin/env bash
# usage: reuse_object.sh COMPILED_BUILD_DIR BUILD_DIR COMPILER ARGUMENT...
#
# A compiler launcher: where COMPILED_BUILD_DIR has an object that the same command made, which its
# compile_commands.json tells, copies that one; else compiles.
set -euo pipefail
compiled=$1 build=$2
shift 2

# The command as compile_commands.json has it: without what asks for a list of headers.
command="" object="" source="" dependencies=""
arguments=("$@")
for ((i = 0; i < ${#arguments[@]}; ++i)); do
  case ${arguments[i]} in
    -MD) continue ;;
    -MT) ((++i)); continue ;;
    -MF) dependencies=${arguments[++i]}; continue ;;
    -o) object=${arguments[i + 1]} ;;
    -c) source=${arguments[i + 1]} ;;
  esac
  command+="${arguments[i]} "
done
command=${command% }
command=${command//"$build"/"$compiled"}
made=${PWD/#"$build"/"$compiled"}/$object

# Quotes differ: they are left out on both sides.
if [[ $object && -e $made ]] &&
  grep -F " -c $source\"" "$compiled/compile_commands.json" | tr -d '\\"' |
  grep -qFx -- "  command: ${command//[\"\\]/},"; then
  cp "$made" "$object"
  [[ -z $dependencies ]] || echo "$object: $source" >"$dependencies"
else
  exec "$@"
fi
