#!/bin/sh
# usage: on_one_processor.sh COMMAND [ARGUMENTS...]
#
# Runs a command on the first of the processors that it may use: oneTBB then works with one thread.
set -eu

allowed=$(taskset --cpu-list --pid $$)  # pid 42's current affinity list: 2-5,7
first=${allowed##*: }
first=${first%%[-,]*}
exec taskset --cpu-list "$first" "$@"
