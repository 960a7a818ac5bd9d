"""The floors of the house: what a room may import, and that no two files import each other."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

# From the ground up. A room may import those on floors below its own; rooms of one floor do not know one another.
FLOORS = (
    ("metrics", "avs.system", "avs.rasterizer"),
    ("avs.scene",),
    ("avs.sfm",),
    ("avs.datasets", "avs.representations"),
    ("avs.selection",),
    ("avs.iqa",),
    ("avs.selectors",),
    ("avs.nvs", "avs.slam"),
    ("avs.coverage",),
    ("avs.report",),
    ("avs.config",),
    ("avs.commands",),
    ("avs.__main__",),
)
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def modules():
    """Return every module of the project by dotted name."""
    files = [path for name in ("avs", "metrics") for path in (ROOT / name).rglob("*.py")]
    return {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in files}


MODULES = modules()


def imports(path):
    """Return the modules of the project that a file imports, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            named = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (named & MODULES.keys()) or {node.module}
    return found & MODULES.keys()


IMPORTS = {name: imports(path) for name, path in MODULES.items()}


def room(module):
    """Return the room of a module: ``metrics``, or a folder or file of ``avs``."""
    parts = module.split(".")
    return parts[0] if parts[0] == "metrics" else ".".join(parts[:2])


def test_every_room_has_its_floor():
    rooms = {room(name) for name in MODULES} - {"avs"}
    assert rooms == FLOOR_OF.keys()


def test_no_file_imports_upward_or_across():
    upward = [
        f"{name} imports {other}"
        for name, others in IMPORTS.items()
        for other in sorted(others)
        if room(name) != room(other) and FLOOR_OF[room(other)] >= FLOOR_OF[room(name)]
    ]
    assert not upward, "\n".join(upward)


def test_no_two_files_import_each_other():
    waiting, done = {name: set(others) - {name} for name, others in IMPORTS.items()}, set()
    while ready := [name for name, others in waiting.items() if others <= done]:
        done.update(ready)
        for name in ready:
            del waiting[name]
    assert not waiting, f"a circle among {', '.join(sorted(waiting))}"


def test_no_two_files_share_a_name():
    seen = {}
    for name, path in MODULES.items():
        if path.name != "__init__.py":
            seen.setdefault(path.stem, []).append(name)
    shared = {stem: names for stem, names in seen.items() if len(names) > 1}
    assert not shared, shared


def test_the_top_of_the_library_is_short():
    entries = [path for path in (ROOT / "avs").iterdir() if path.name != "__pycache__"]
    assert len(entries) <= 20
