"""Whole programs on Embree and on dacrt, in turn: what tests/bench/cycles, tutorials and verify share."""

import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
import sys


def options(text, rounds):
    """The options that all such benchmarks have. `text` is the benchmark's own."""
    parser = argparse.ArgumentParser(description=text.splitlines()[0])
    parser.add_argument("drop_in", type=os.path.abspath)
    parser.add_argument("--rounds", type=int, default=rounds)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--json")
    return parser


def need(files, packages):
    """Ends with what means skipped to ctest if a program, or a file with its path, is missing."""
    for file in files:
        if not (os.path.exists(file) if file.startswith("/") else shutil.which(file)):
            print("%s is missing (Debian: %s)" % (file, packages))
            sys.exit(77)


def run(command, drop_in, processors=None):
    """What the program writes. On dacrt if `drop_in` is its folder."""
    environment = dict(os.environ)
    if drop_in:
        environment.update(LD_LIBRARY_PATH=drop_in, LD_DEBUG="libs")  # the loader says what it takes
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True,
        preexec_fn=(lambda: os.sched_setaffinity(0, processors)) if processors else None)
    if drop_in and "calling init: %s/libembree3.so.3" % drop_in not in done.stderr:
        sys.exit("%s has no drop-in that %s takes" % (drop_in, command[0]))
    return done.stdout


def figure(command, pattern, drop_in, processors=None):
    """The number that the program writes behind `pattern`."""
    output = run(command, drop_in, processors)
    found = re.search(r"^\s*" + pattern + r" *([\d.]+)", output, re.M)
    if not found:
        sys.exit("%s on %s says nothing:\n%s" % (" ".join(command), drop_in or "Embree", output[-2000:]))
    return float(found[1])


def medians(args, measure):
    """Of the rounds of `measure(drop_in)`: Embree's and dacrt's."""
    rounds = [(measure(None), measure(args.drop_in)) for _ in range(args.rounds)]
    return [statistics.median(of_library) for of_library in zip(*rounds)]


def write(args, results):
    if args.json:
        with open(args.json, "w") as file:
            json.dump({"settings": vars(args), "results": results}, file, indent=1)
