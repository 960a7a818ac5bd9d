"""What can happen to a finished run between two calls. Each function does one such thing and tells what it did."""

import json
import os
import shutil

import yaml

from tests.endurance.project import configuration, finish, killed_run

FOLDERS = ("scenes", "episodes", "scorer", "distortions", "common_states", "coverage", "settings", "tables", "figures")


def _files(folder, rooms=FOLDERS):
    """Return the files of the results that a run makes, apart from what differs from run to run."""
    root = folder / "results" / "tiny"
    found = sorted(path for room in rooms for path in (root / room).rglob("*") if path.is_file())
    return [path for path in found if not path.name.endswith(".meta.json")]


def _one(folder, chance, *, filled=False):
    """Choose a room of the results, then a file of it: most files are photographs, which all else follows from."""
    rooms = [[path for path in _files(folder, (room,)) if path.stat().st_size or not filled] for room in FOLDERS]
    return chance.choice(chance.choice([files for files in rooms if files]))


def delete(folder, chance):
    """Delete one file."""
    path = _one(folder, chance)
    path.unlink()
    return f"deleted {path.relative_to(folder)}"


def delete_folder(folder, chance):
    """Delete a folder with all that is in it."""
    path = _one(folder, chance).parent
    shutil.rmtree(path)
    return f"deleted {path.relative_to(folder)}/"


def flip(folder, chance):
    """Flip one bit of one file, whose time stays in half of the cases, as when a disk fails."""
    path = _one(folder, chance, filled=True)
    status, content = path.stat(), bytearray(path.read_bytes())
    place = chance.randrange(len(content))
    content[place] ^= 1 << chance.randrange(8)
    path.write_bytes(content)
    if chance.random() < 0.5:
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    return f"flipped a bit of byte {place} of {path.relative_to(folder)}"


def truncate(folder, chance):
    """Cut a file off."""
    path = _one(folder, chance, filled=True)
    length = chance.randrange(path.stat().st_size)
    os.truncate(path, length)
    return f"cut {path.relative_to(folder)} to {length} bytes"


def edit_settings(folder, chance):
    """Change a digit in a file of settings, by hand or as a program that gives it a digest of its own."""
    path = chance.choice(_files(folder, ("settings",)))
    text = path.read_text()
    places = [place for place, letter in enumerate(text) if letter.isdigit()]
    place = chance.choice(places)
    path.write_text(text[:place] + str((int(text[place]) + 1) % 10) + text[place + 1 :])
    return f"changed digit {place} of {path.relative_to(folder)}"


def edit_record(folder, chance):
    """Change a number in an episode's record."""
    path = chance.choice([path for path in _files(folder, ("episodes",)) if path.name == "episode.json"])
    values = json.loads(path.read_text())
    values["curve"][-1]["iteration"] += 1
    path.write_text(json.dumps(values))
    return f"changed a number of {path.relative_to(folder)}"


def old_times(folder, chance):
    """Make a file older or newer than all others."""
    path = _one(folder, chance)
    time = chance.choice([1_000_000_000, 4_000_000_000])
    os.utime(path, (time, time))
    return f"dated {path.relative_to(folder)} {time}"


def forget(folder, chance):
    """Delete what Snakemake or the jobs noted of a run."""
    path = chance.choice([folder / ".snakemake", folder / "results/tiny/logs", folder / "results/tiny/plan.json"])
    (shutil.rmtree if path.is_dir() else os.unlink)(path)
    return f"deleted {path.relative_to(folder)}"


def configure_and_back(folder, chance):
    """Change the configuration, run until something is killed or all is done, and change it back."""
    edits = [
        {"seeds": [0, 1]},
        {"methods": ["random", "backwards"]},
        {"selectors": {"random": {"reshuffle": True}}},
        {"protocol": configuration()["protocol"] | {"iterations": 13}},
        {"common_states": None},
    ]
    edit = chance.choice(edits)
    (folder / "tiny.yaml").write_text(yaml.safe_dump(configuration() | edit))
    told = f"configured {next(iter(edit))}, then {_run_or_kill(folder, chance)}, then configured as before"
    (folder / "tiny.yaml").write_text(yaml.safe_dump(configuration()))
    return told


def capture_and_back(folder, chance):
    """Change a photograph of a capture, run, and change it back."""
    images = folder / "captures" / "desk" / "images"
    path, other = chance.sample(sorted(images.iterdir()), 2)
    content = path.read_bytes()
    path.write_bytes(other.read_bytes())
    told = f"changed {path.relative_to(folder)}, then {_run_or_kill(folder, chance)}, then changed it back"
    path.write_bytes(content)
    return told


def program_and_back(folder, chance):
    """Edit the program of a baseline, run, and edit it back."""
    path = folder / "backwards.py"
    content = path.read_text()
    path.write_text(content.replace("views[::-1]", "views"))
    told = f"edited {path.name}, then {_run_or_kill(folder, chance)}, then edited it back"
    path.write_text(content)
    return told


def kill(folder, chance):
    """Delete some results, and kill the run that makes them again."""
    gone = [delete(folder, chance), delete_folder(folder, chance)]
    return f"{'; '.join(gone)}; {_kill(folder, chance)}"


def _run_or_kill(folder, chance):
    if chance.random() < 0.3:
        finish(folder)
        return "ran"
    return _kill(folder, chance)


def _kill(folder, chance):
    seconds, whom = chance.uniform(1, 30), chance.choice(["main", "all", "job"])
    killed_run(folder, seconds, whom, chance.choice)
    return f"killed {whom} after {seconds:.1f} s"


STATES = (
    delete,
    delete_folder,
    flip,
    truncate,
    edit_settings,
    edit_record,
    old_times,
    forget,
    configure_and_back,
    capture_and_back,
    program_and_back,
    kill,
)
