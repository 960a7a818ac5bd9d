"""Runs random states and kills against a run from nothing: ``python -m tests.endurance --help``."""

import argparse
import random
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.endurance.project import copy, difference, finish, lay_out, results
from tests.endurance.states import STATES, kill


def main():
    """Print a line for each state, and exit with 1 if one ended otherwise than a run from nothing."""
    parser = argparse.ArgumentParser(prog="python -m tests.endurance", description=__doc__)
    parser.add_argument("--states", type=int, default=40, help="random states, numbered from 0")
    parser.add_argument("--kills", type=int, default=50, help="kill -9 at random times, numbered from 0")
    parser.add_argument("--first", type=int, default=0, help="number of the first of each")
    parser.add_argument(
        "--seed", type=int, default=0, help="what all chances follow from, with the number of the state"
    )
    parser.add_argument(
        "--folder", type=Path, help="where to work, and to leave what failed; a temporary one by default"
    )
    told = parser.parse_args()
    folder = told.folder or Path(tempfile.mkdtemp(prefix="endurance-"))
    finished = folder / "finished"
    if not finished.exists():
        finish(lay_out(finished))
    expected = results(finished)
    print(f"seed {told.seed}, in {folder}: {len(expected)} files to compare", flush=True)
    wanted = [("state", number) for number in range(told.first, told.states)]
    wanted += [("kill", number) for number in range(told.first, told.kills)]
    failed = [f"{kind} {number}" for kind, number in wanted if not _holds(kind, number, told.seed, folder, expected)]
    print(
        f"{len(wanted) - len(failed)} of {len(wanted)} end as a run from nothing; failed: {', '.join(failed) or 'none'}"
    )
    sys.exit(bool(failed))


def _holds(kind, number, seed, folder, expected):
    """Bring a copy into a state, complete the run, and return whether all is as expected; keep the copy if not."""
    chance = random.Random(f"{seed} {kind} {number}")
    place = copy(folder / "finished", folder / f"{kind}-{number}")
    act = kill if kind == "kill" else STATES[number % len(STATES)]
    told = fault = ""
    try:
        told = act(place, chance)
        finish(place)
        fault = ", ".join(difference(results(place), expected))
    except AssertionError as error:
        fault = str(error)
    print(f"{kind} {number}: {told}: {f'DIFFERENT: {fault}' if fault else 'the same'}", flush=True)
    if not fault:
        shutil.rmtree(place)
    return not fault


if __name__ == "__main__":
    main()
