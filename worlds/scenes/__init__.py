"""Scenes as data: the built-in ones by name, and a user's own from a TOML file."""

from __future__ import annotations

from pathlib import Path

from worlds.errors import UnknownNameError
from worlds.scenes.builtin import BUILTIN
from worlds.scenes.model import Box, Lane, Scene, Start
from worlds.scenes.reader import read_scene

__all__ = ["Box", "Lane", "Scene", "Start", "find_scene", "read_scene", "scene_names"]


def scene_names() -> tuple[str, ...]:
    """Return the names of the built-in scenes."""
    return tuple(BUILTIN)


def find_scene(name: str, seed: int = 0) -> Scene:
    """Return a built-in scene by name, or read the scene file a name ending in ``.toml`` points to.

    Args:
        name: a built-in name or a path.
        seed: where boxes are placed at random, which placement; the same seed gives the same scene.

    Raises:
        UnknownNameError: no such scene.
        SceneFileError: the file cannot be read or is not a scene.
    """
    if name.endswith(".toml"):
        return read_scene(Path(name))
    try:
        return BUILTIN[name](seed)
    except KeyError:
        raise UnknownNameError("scene", name, BUILTIN) from None
