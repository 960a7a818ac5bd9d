"""Compares what the stages compute here with golden.json: ``python -m tests.golden --help``."""

import argparse
import json
import shlex
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from avs.system.compatibility import prepare_environment

prepare_environment()

from tests.golden.stages import (  # noqa: E402 - imports numpy
    GOLDEN,
    digests,
    expected,
    kind_of_processor,
    kinds_that_agree,
    reason_not_to_compare,
    versions,
)


def main():
    """Print a line for each stage, and exit with 1 at the first that differs.

    Where all are the listed ones, the list notes that this kind of processor agrees.
    """
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument("--write", action="store_true", help="write golden.json instead, after a change of numbers")
    parser.add_argument(
        "--emulator",
        default="",
        help="a command that runs the interpreter as on another processor, such as 'qemu-x86_64 -cpu EPYC-Rome'",
    )
    parser.add_argument("--libraries", action="store_true", help="what libraries compute alone, without jobs")
    told = parser.parse_args()
    reason = None if told.write else reason_not_to_compare()
    if reason:
        sys.exit(reason)
    known, found = {} if told.write else expected(), {}
    with tempfile.TemporaryDirectory() as folder:
        for stage, digest in digests(Path(folder), shlex.split(told.emulator), told.libraries):
            fault = "" if told.write or known[stage] == digest else ": DIFFERENT"
            print(f"{stage}{fault}", flush=True)
            if fault:
                sys.exit(1)
            found[stage] = digest
    if told.write:
        agreed = [kind_of_processor()]
    elif not told.emulator and not told.libraries:
        agreed = sorted({*kinds_that_agree(), kind_of_processor()})
    else:
        return
    GOLDEN.write_text(json.dumps({"agreed": agreed, "packages": versions(), "digests": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
