"""Snapshots of a whole chip: the machine goes on from one as it went on from there the first time.

A snapshot is put back into the machine that it was taken of, in the same process, as often as wanted.
It has three parts:

* The state in C: core, exceptions, SysTick, queue of events, and the blocks in C, as one piece of memory
  (``snapshot.c``); and the request lines to DMA.
* Memory that programs see.
* The state in Python: what the objects of the chip hold, found by following them from the machine on. An object is put
  back by giving it what it held, so that all who refer to it still do: callbacks, events, lambdas.

Everything that is found must be of a kind of which this module knows how it is saved: objects of `targets.mcu`,
containers, closures, plain data. Of anything else it says what is in the way, and takes no snapshot. Callbacks of
others (a bench, a recorder) are kept as they are set, but not followed: the state of those outside is for them to save.
So are breakpoints, watchpoints, edges and logs of `Hooks`, and what was executed: they belong to whoever looks.
"""

from __future__ import annotations

import ctypes
import enum
import functools
import types
from collections import deque
from collections.abc import Callable
from fractions import Fraction
from pathlib import PurePath
from random import Random
from typing import TYPE_CHECKING, Any

from targets.mcu.engine.counted import CountedLoops
from targets.mcu.engine.hooks import Hooks
from targets.mcu.errors import McuError
from targets.mcu.image import Image
from targets.mcu.pins import Pins
from targets.mcu.stm32.dma_requests import Requests

if TYPE_CHECKING:
    from targets.mcu.machine import Machine

__all__ = ["NotSaved", "Snapshot"]

_PLAIN = (
    type(None), bool, int, float, complex, str, bytes, Fraction, range, slice, enum.Enum, PurePath, type,
    types.ModuleType, types.BuiltinFunctionType, memoryview, ctypes.CDLL,
    ctypes._CFuncPtr,  # type: ignore[attr-defined]  # noqa: SLF001 - it has no other name
)  # fmt: skip
"""What never changes, functions of C, and views, whose memory is saved where it belongs."""
_NOT_FOLLOWED = (CountedLoops, Hooks, Image)
"""What tells how to execute, or what was asked for, and nothing of the chip's state."""
_OUTSIDE = ("targets.mcu.trace", "targets.mcu.testing")

_PutBack = Callable[[], object]
_Path = tuple[Any, str]  # that of the owner, and what it is called there


class NotSaved(McuError):  # noqa: N818 - the sentence is about what is named
    """Something of the chip cannot be saved yet; the text says what."""


class Snapshot:
    """What a machine is at present; see the module.

    Args:
        machine: between two runs. It may stand at a hit.

    Raises:
        NotSaved: something cannot be saved. The machine is as it was.
        ValueError: the machine runs.
    """

    def __init__(self, machine: Machine) -> None:
        self._engine = machine.engine
        self._check_that_it_stands()
        self._memories = [(memory, bytes(memory.data)) for memory in machine.chip.memories]
        self._put_back = _Walk(machine, {id(memory.data) for memory, _ in self._memories}).put_back
        self._in_c = machine.engine.save()

    def restore(self) -> None:
        """Make the machine what it was.

        Raises:
            ValueError: the machine runs.
        """
        self._check_that_it_stands()
        for memory, data in self._memories:
            if memory.data != data:
                memory.data[:] = data
                self._engine.forget(memory.base, len(data))
        for put_back in self._put_back:
            put_back()
        self._engine.restore(self._in_c)

    def _check_that_it_stands(self) -> None:
        if self._engine.running:
            raise ValueError("a snapshot is taken and put back between two runs, not within one")


class _Walk:
    """Follows what belongs to a chip, from a machine on.

    Args:
        machine: where it begins.
        memories: the `id` of each memory that is saved otherwise.

    Attributes:
        put_back: for each thing that may change, what puts back what it is now.
    """

    def __init__(self, machine: Machine, memories: set[int]) -> None:
        self.put_back: list[_PutBack] = []
        self._memories = memories
        self._pins = machine.chip.pins
        self._seen: dict[int, object] = {}  # kept alive, as places in memory are compared
        self._todo: deque[tuple[Any, _Path]] = deque([(machine, ((), "machine"))])
        self._savers: dict[type, Callable[[Any, _Path], None]] = {
            **dict.fromkeys((tuple, frozenset), self._follow_each),
            **dict.fromkeys((list, deque, set), self._save_sequence),
            dict: self._save_dict,
            Pins: self._save_pins,
            bytearray: self._save_bytes,
            Random: self._save_chance,
            types.MappingProxyType: lambda one, path: self._save_dict(dict(one), path),
            types.MethodType: self._follow_method,
            types.FunctionType: self._follow_function,
            types.CellType: self._save_cell,
            functools.partial: self._follow_partial,
        }
        while self._todo:
            one, path = self._todo.popleft()
            if id(one) not in self._seen:
                self._seen[id(one)] = one
                self._savers.get(type(one), self._save_other)(one, path)

    def _follow(self, one: object, path: _Path, name: str = "") -> None:
        kind: Any = type(one)
        if not _is_left(kind):
            self._todo.append((one, (path, name)))

    def _follow_each(self, one: Any, path: _Path) -> None:
        for value in one:
            self._follow(value, path, "[...]")

    # --- containers

    def _save_sequence(self, one: Any, path: _Path) -> None:
        self._follow_each(one, path)
        self.put_back.append(functools.partial(_renew, one, tuple(one)))

    def _save_dict(self, one: dict[Any, Any], path: _Path) -> None:
        for key, value in one.items():
            self._follow(key, path, "[key]")
            self._follow(value, path, "[...]")
        self.put_back.append(functools.partial(_refill, one, dict(one)))

    def _save_bytes(self, one: bytearray, _path: _Path) -> None:
        if id(one) not in self._memories:
            self.put_back.append(functools.partial(one.__setitem__, slice(None), bytes(one)))

    def _save_chance(self, one: Random, _path: _Path) -> None:
        self.put_back.append(functools.partial(one.setstate, one.getstate()))

    # --- what is called

    def _follow_method(self, one: types.MethodType, path: _Path) -> None:
        if _is_inside(one.__self__):
            self._follow(one.__self__, path)

    def _follow_function(self, one: types.FunctionType, path: _Path) -> None:
        if _is_inside(one):
            for part in (*(one.__closure__ or ()), one.__defaults__, one.__kwdefaults__):
                self._follow(part, path)

    def _save_cell(self, one: types.CellType, path: _Path) -> None:
        self._follow(one.cell_contents, path)
        self.put_back.append(functools.partial(setattr, one, "cell_contents", one.cell_contents))

    def _follow_partial(self, one: functools.partial[Any], path: _Path) -> None:
        if _is_inside(getattr(one.func, "__self__", one.func)):
            for part in (one.func, one.args, one.keywords):
                self._follow(part, path)

    # --- objects

    def _save_other(self, one: Any, path: _Path) -> None:
        if isinstance(one, (ctypes.Structure, ctypes.Array, ctypes.c_void_p)):
            if one._b_needsfree_:  # otherwise its memory is somebody else's
                kept = bytes(one)
                self.put_back.append(functools.partial(ctypes.memmove, ctypes.addressof(one), kept, len(kept)))
        elif isinstance(one, Requests):
            self.put_back.append(one.save())
            self._save_object(one, path)
        elif _is_inside(one) or type(one).__module__.startswith("targets.boards"):
            self._save_object(one, path)
        else:
            what = f"{type(one).__module__}.{type(one).__qualname__}"
            raise NotSaved(f"{_named(path)}: {what} is no part of the chip, and cannot be saved")

    def _save_pins(self, one: Pins, path: _Path) -> None:
        if one is not self._pins:
            raise NotSaved(f"{_named(path)}: a wire leads to another chip, and neither can be saved alone")
        self._save_object(one, path)

    def _save_object(self, one: Any, path: _Path) -> None:
        changes = not getattr(getattr(one, "__dataclass_params__", None), "frozen", False)
        held = getattr(one, "__dict__", None)
        if held is not None:
            for name, value in held.items():
                self._follow(value, path, f".{name}")
            if changes:
                self.put_back.append(functools.partial(_refill, held, dict(held)))
        kind: Any = type(one)
        for place in _places(kind):
            value = getattr(one, place.__name__, place)
            if value is not place:
                self._follow(value, path, f".{place.__name__}")
            if changes:
                empty = value is place
                self.put_back.append(
                    functools.partial(_empty, one, place) if empty else functools.partial(place.__set__, one, value)
                )


@functools.cache
def _is_left(kind: Any) -> bool:
    """Say whether what is of that class is neither saved nor followed."""
    return issubclass(kind, (*_PLAIN, *_NOT_FOLLOWED))


@functools.cache
def _places(kind: Any) -> tuple[types.MemberDescriptorType, ...]:
    """Return the slots of a class."""
    return tuple(
        place for one in kind.__mro__ for place in vars(one).values() if isinstance(place, types.MemberDescriptorType)
    )


def _is_inside(one: Any) -> bool:
    """Say whether an object, a class or a function is the chip's."""
    module = getattr(one, "__module__", None) or ""
    return module.startswith("targets.mcu.") and module not in _OUTSIDE


def _named(path: _Path) -> str:
    owner, name = path
    return (_named(owner) if owner else "") + name


def _refill(one: dict[Any, Any], held: dict[Any, Any]) -> None:
    one.clear()
    one.update(held)


def _renew(one: Any, held: tuple[Any, ...]) -> None:
    one.clear()
    (one.update if isinstance(one, set) else one.extend)(held)


def _empty(one: object, place: types.MemberDescriptorType) -> None:
    if hasattr(one, place.__name__):
        place.__delete__(one)
