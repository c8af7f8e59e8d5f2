"""Where a run ends because somebody wants to look: ``--break`` and ``--watch``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from hilbench.errors import UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.nearest import nearest
from targets.mcu.image import Image

__all__ = ["set_stops"]

_WORD = 1 << 32
_Place = tuple[int, int]  # address and size in bytes


def set_stops(emulated: EmulatedBench, breaks: Iterable[str], watches: Iterable[str]) -> None:
    """Have the run end before a board executes one of `breaks`, or writes to one of `watches`.

    Args:
        emulated: the bench, before it runs.
        breaks: names of functions, or addresses; of several of a name, all.
        watches: names of variables, or addresses of words; the same.

    Raises:
        UsageError: no image has that symbol, or there are too many.
    """
    images = emulated.images
    broken = [_places(images, text, "--break") for text in breaks]
    watched = [_places(images, text, "--watch") for text in watches]
    if not broken and not watched:
        return
    for name, machine in emulated.machines.items():
        addresses = [address for places in broken for address, _size in places[name]]
        written = [place for places in watched for place in places[name]]
        try:
            machine.stop_at(addresses, written)
        except ValueError as error:
            raise UsageError(str(error), where="run", hint="give fewer") from None


def _places(images: Mapping[str, Image], text: str, option: str) -> Mapping[str, Collection[_Place]]:
    """Return what `text` names, by board: of static functions and variables there may be several of a name."""
    try:
        address = int(text, 0)
    except ValueError:
        places = {
            name: {(symbol.address, symbol.size or 4) for symbol in image.symbols.all if symbol.name == text}
            for name, image in images.items()
        }
        if not any(places.values()):
            known = (symbol.name for image in images.values() for symbol in image.symbols.all)
            near = nearest(text, known)
            hint = f"did you mean '{near}'?" if near else "give a symbol of the ELF file, or an address: 0x08000100"
            raise UsageError(f"no image has a symbol '{text}'", where=option, hint=hint) from None
        return places
    if not 0 <= address <= _WORD - 4:
        raise UsageError(f"'{text}' is no address of 32 bits", where=option)
    return dict.fromkeys(images, ((address, 4),))
