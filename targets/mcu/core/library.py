"""Loads the library, and makes ctypes of its structs.

`load` compiles it first where it is missing or not of the sources beside it, as after a ``git pull``.
"""

from __future__ import annotations

import ctypes
import functools
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from targets.mcu.core.sources import current, digest_of, places
from targets.mcu.errors import EngineError

__all__ = ["About", "Row", "about", "load", "open_library", "owner_of", "structure", "structures_of", "with_lock_held"]

_REBUILD = f"{sys.executable} -m targets.mcu.core.build"

_TYPES: Mapping[str, type] = {
    "const char *": ctypes.c_char_p,
    "void *": ctypes.c_void_p,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    **{f"int{bits}_t": getattr(ctypes, f"c_int{bits}") for bits in (8, 16, 32, 64)},
    **{f"uint{bits}_t": getattr(ctypes, f"c_uint{bits}") for bits in (8, 16, 32, 64)},
}


class Row(ctypes.Structure):
    """``struct hil_row`` (`layout.h`), by which the table of all structs is read."""

    _fields_ = (
        ("structure", ctypes.c_char_p),
        ("field", ctypes.c_char_p),
        ("type", ctypes.c_char_p),
        ("offset", ctypes.c_uint32),
        ("size", ctypes.c_uint32),
        ("count", ctypes.c_uint32),
    )


@dataclass(frozen=True, slots=True)
class About:
    """What is known of a library.

    Attributes:
        path: its file.
        compiler: name and version of what compiled it.
        digest: of its sources, in hexadecimal.
    """

    path: Path
    compiler: str
    digest: str


@functools.cache
def load() -> ctypes.CDLL:
    """Return the library of the sources beside this file.

    Raises:
        EngineError: there is none, and it cannot be compiled, or it cannot be loaded.
    """
    return open_library(*_found())


def with_lock_held() -> Any:
    """Return the library as one whose functions keep Python's lock, for the caller to declare them: see `load`."""
    return ctypes.PyDLL("", handle=load()._handle)  # noqa: SLF001


def owner_of(unraisable: Any) -> object:
    """Return whose method ctypes has called, where what that raised at its entry comes to `sys.unraisablehook`.

    From CPython 3.13 on the callback is not handed over; then it is the outermost frame whose ``self`` is it.
    """
    if unraisable.object is not None:
        return getattr(unraisable.object, "__self__", None)
    frames = unraisable.exc_traceback
    return None if frames is None else frames.tb_frame.f_locals.get("self")


@functools.cache
def _found() -> tuple[Path, str]:
    """Return the library's file and the digest of its sources."""
    digest = digest_of()
    path = current(digest, places(digest))
    if path is None:
        from targets.mcu.core.build import build

        path = build()
    return path, digest


def open_library(path: Path, digest: str) -> ctypes.CDLL:
    """Return the library in a file, which must be of the sources with that digest.

    Raises:
        EngineError: it cannot be loaded, or is of other sources.
    """
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise EngineError(f"cannot be loaded: {error}", where=str(path), hint=f"remove it, then: {_REBUILD}") from error
    for function in (library.hil_sources_digest, library.hil_compiler):
        function.argtypes, function.restype = (), ctypes.c_char_p
    library.hil_layout.argtypes, library.hil_layout.restype = (), ctypes.POINTER(Row)
    if library.hil_sources_digest().decode() != digest:
        raise EngineError("is of other sources than those beside it", where=str(path), hint=_REBUILD)
    return library


def about() -> About:
    """Return what is known of the library that `load` returns; raises what that raises."""
    path, digest = _found()
    return About(path, load().hil_compiler().decode().strip(), digest)


def structure(name: str) -> type[ctypes.Structure]:
    """Return the struct of that name, such as ``hil_cpu``, of the library that `load` returns.

    Its instances take no attribute that is no field.

    Raises:
        EngineError: as `load`; or ctypes lays a struct out in another way than the C compiler.
        KeyError: the library lists no such struct.
    """
    return _structures()[name]


@functools.cache
def _structures() -> Mapping[str, type[ctypes.Structure]]:
    return structures_of(_rows(load()))


def _rows(library: ctypes.CDLL) -> Iterator[Row]:
    table = library.hil_layout()
    index = 0
    while table[index].structure is not None:
        yield table[index]
        index += 1


def structures_of(rows: Iterable[Row]) -> Mapping[str, type[ctypes.Structure]]:
    """Return the structs of a table by their names.

    Raises:
        EngineError: ctypes lays one out in another way than the C compiler, or a type is not known here.
    """
    members: dict[str, list[Row]] = {}
    for row in rows:
        members.setdefault(row.structure.decode(), []).append(row)
    made: dict[str, type[ctypes.Structure]] = {}
    for name, (whole, *fields) in members.items():
        content = [(row.field.decode(), _type_of(row, made)) for row in fields]
        made[name] = type(name, (ctypes.Structure,), {"_fields_": content, "__slots__": ()})
        _compare(made[name], whole, fields)
    return made


def _type_of(row: Row, made: Mapping[str, type]) -> type:
    text = row.type.decode()
    known = made.get(text.removeprefix("struct ")) or _TYPES.get(text)
    if known is None:
        raise _misfit(row, f"has the type '{text}', which is none of those in layout.h")
    return known * row.count if row.count else known


def _compare(made: type[ctypes.Structure], whole: Row, fields: Sequence[Row]) -> None:
    for row in fields:
        member = getattr(made, row.field.decode())
        if (member.offset, member.size) != (row.offset, row.size):
            text = f"has {row.size} bytes at {row.offset} in C, {member.size} at {member.offset} in Python"
            raise _misfit(row, text)
    if ctypes.sizeof(made) != whole.size:
        raise _misfit(whole, f"has {whole.size} bytes in C, {ctypes.sizeof(made)} in Python")


def _misfit(row: Row, text: str) -> EngineError:
    what = ".".join(part.decode() for part in (row.structure, row.field) if part)
    return EngineError(f"{what} {text}", where="the library of the emulated CPU", hint=_REBUILD)
