"""Firmware of our own for the emulated chips: C sources, and the images built from them."""

from __future__ import annotations

from pathlib import Path

__all__ = ["image_names", "image_path"]

_IMAGES = Path(__file__).parent / "images"


def image_names() -> tuple[str, ...]:
    """Return the names of all images, without the ending, in alphabetical order."""
    return tuple(sorted(path.stem for path in _IMAGES.glob("*.elf")))


def image_path(name: str) -> Path:
    """Return where an image lies.

    Args:
        name: such as ``selftest-crc``, which is the ELF file, or ``selftest-crc.hex`` and ``selftest-crc.bin`` where
            the image comes in these formats too.

    Raises:
        FileNotFoundError: there is no such image; the text lists those there are.
    """
    for path in (_IMAGES / name, _IMAGES / f"{name}.elf"):
        if path.is_file():
            return path
    raise FileNotFoundError(f"no image {name!r} in {_IMAGES}; there are: {', '.join(image_names())}")
