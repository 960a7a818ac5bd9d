"""Stand-ins for shared libraries whose functions a program is linked to but never calls.

The dynamic linker refuses a library, Open3D's for example, as soon as one that it is linked to is missing, even if that
one is only for windows. A stand-in has the missing library's name and defines the functions that are asked for; each
returns zero, which in the graphics libraries means failure. It is an ELF file in memory, for Linux on x86-64, laid out
after the System V ABI (https://refspecs.linuxfoundation.org/elf/gabi4+/contents.html).
"""

from __future__ import annotations

import ctypes
import itertools
import mmap
import os
import struct
from collections.abc import Sequence
from pathlib import Path

_PAGE = 0x1000
_RETURN_ZERO = bytes.fromhex("31c0c3")  # xor eax, eax; ret
_X86_64 = 62
_SHARED_OBJECT = 3
_DYNAMIC_SYMBOLS = 11  # type of a section

_HEADER = struct.Struct("<16sHHIQQQIHHHHHH")
_SEGMENT = struct.Struct("<IIQQQQQQ")
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_VERSION = struct.Struct("<HHHHIIIII")  # a definition with its one name
_GLOBAL_FUNCTION = 0x12

# Tags of the dynamic section.
_HASH, _STRINGS, _SYMBOLS, _STRINGS_SIZE, _SYMBOL_SIZE, _SONAME = 4, 5, 6, 10, 11, 14
_SYMBOL_VERSIONS, _VERSIONS, _VERSION_COUNT = 0x6FFFFFF0, 0x6FFFFFFC, 0x6FFFFFFD

# Type, permissions, place and alignment of the segments.
_EXECUTE, _WRITE, _READ = 1, 2, 4
_TEXT, _DATA, _NOWHERE = range(3)
_SEGMENTS = (
    (1, _READ | _EXECUTE, _TEXT, _PAGE),  # load
    (1, _READ | _WRITE, _DATA, _PAGE),  # load
    (2, _READ | _WRITE, _DATA, 8),  # dynamic section
    (0x6474E551, _READ | _WRITE, _NOWHERE, 16),  # a stack that holds no code
)


def undefined_symbols(library: Path) -> list[str]:
    """Return the names that ``library``, an ELF file, expects other libraries to define, ascending."""
    with open(library, "rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        header = _HEADER.unpack_from(data, 0)
        offset, count = header[6], header[12]
        sections = [_SECTION.unpack_from(data, offset + index * _SECTION.size) for index in range(count)]
        names = set()
        for section in sections:
            if section[1] != _DYNAMIC_SYMBOLS:
                continue
            strings = sections[section[6]][4]
            for name, _, _, defined_in, _, _ in _SYMBOL.iter_unpack(data[section[4] : section[4] + section[5]]):
                if name and not defined_in:
                    start = strings + name
                    names.add(data[start : data.find(b"\0", start)].decode())
    return sorted(names)


def load_stub(name: str, symbols: Sequence[str], version: str = "") -> None:
    """Load a stand-in for the library ``name`` into this process, for all later libraries; see ``stub_library``."""
    # The descriptor stays open: the linker would take a second file at the same path for the first.
    descriptor = os.memfd_create(name)
    os.write(descriptor, stub_library(name, symbols, version))
    ctypes.CDLL(f"/proc/self/fd/{descriptor}", mode=ctypes.RTLD_GLOBAL)


def stub_library(name: str, symbols: Sequence[str], version: str = "") -> bytes:
    """Return an ELF shared object named ``name`` that defines ``symbols`` as functions that return zero.

    The first page holds headers, tables and code, the second the dynamic section, into which the linker writes.

    Args:
        name: file name of the library, such as ``libGL.so.1``.
        symbols: names of the functions.
        version: the version that all of them have, such as ``LIBUDEV_183``; empty for a library without versions.
    """
    texts = [name, version, *symbols]
    strings = b"\0" + b"".join(text.encode() + b"\0" for text in texts)
    starts = list(itertools.accumulate((len(text.encode()) + 1 for text in texts), initial=1))
    # One bucket, whose chain goes through all symbols from the last to the first.
    hashes = struct.pack(f"<{4 + len(symbols)}I", 1, len(symbols) + 1, len(symbols), 0, *range(len(symbols)))
    # Version 1 is the library itself, version 2 the symbols'.
    versions = struct.pack(f"<{1 + len(symbols)}H", 0, *[2] * len(symbols))
    definitions = _VERSION.pack(1, 1, 1, 1, _elf_hash(name), 20, 28, starts[0], 0)
    definitions += _VERSION.pack(1, 0, 2, 1, _elf_hash(version), 20, 0, starts[1], 0)
    tables = [bytes((len(symbols) + 1) * _SYMBOL.size), definitions, hashes, versions, strings, _RETURN_ZERO]
    first = _HEADER.size + len(_SEGMENTS) * _SEGMENT.size
    offsets = list(itertools.accumulate((-(-len(table) // 8) * 8 for table in tables), initial=first))
    symbol_table, definition_table, hash_table, version_table, string_table, code, size = offsets
    tables[0] = bytes(_SYMBOL.size) + b"".join(
        _SYMBOL.pack(start, _GLOBAL_FUNCTION, 0, 1, code, len(_RETURN_ZERO)) for start in starts[2:-1]
    )
    entries = {
        _SONAME: starts[0],
        _HASH: hash_table,
        _STRINGS: string_table,
        _SYMBOLS: symbol_table,
        _STRINGS_SIZE: len(strings),
        _SYMBOL_SIZE: _SYMBOL.size,
    }
    if version:
        entries |= {_SYMBOL_VERSIONS: version_table, _VERSIONS: definition_table, _VERSION_COUNT: 2}
    dynamic = b"".join(struct.pack("<2Q", *entry) for entry in [*entries.items(), (0, 0)])
    start = -(-size // _PAGE) * _PAGE
    places = {_TEXT: (0, size), _DATA: (start, len(dynamic)), _NOWHERE: (0, 0)}
    content = _header()
    for kind, flags, place, alignment in _SEGMENTS:
        offset, length = places[place]
        content += _SEGMENT.pack(kind, flags, offset, offset, offset, length, length, alignment)
    content += b"".join(table.ljust(-(-len(table) // 8) * 8, b"\0") for table in tables)
    return content.ljust(start, b"\0") + dynamic


def _header() -> bytes:
    sizes = (_HEADER.size, _SEGMENT.size, len(_SEGMENTS), 0, 0, 0)
    return _HEADER.pack(b"\x7fELF\x02\x01\x01", _SHARED_OBJECT, _X86_64, 1, 0, _HEADER.size, 0, 0, *sizes)


def _elf_hash(text: str) -> int:
    """The hash function of the System V ABI, by which the linker compares names of versions."""
    value = 0
    for byte in text.encode():
        value = (value << 4) + byte
        high = value & 0xF0000000
        value = (value ^ high >> 24) & ~high
    return value
