"""The JSON Schema of bench files, for completion in editors; it is published as ``hilbench/data/bench.schema.json``."""

from __future__ import annotations

import dataclasses
from typing import Any

import msgspec

from hilbench.benchfile.bench_model import BenchModel
from hilbench.plugins.discovery import PLUGINS
from hilbench.strict.schema import json_schema

__all__ = ["bench_schema"]


def bench_schema() -> dict[str, Any]:
    """Return the JSON Schema of bench files."""
    schema = json_schema(BenchModel, "hilbench bench file")
    systems = [system for system in PLUGINS.systems.there() if PLUGINS.systems.is_own(system.name)]
    there = {name: kind for system in systems for name, kind in system.models().items()}
    kinds = [kind.settings for kind in there.values()]
    models, known = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    for model, definition in zip(kinds, (known[one.__name__] for one in kinds), strict=True):
        definition["additionalProperties"] = False
        definition["description"] = " ".join(definition["description"].partition("Raises:")[0].split())
        for item in dataclasses.fields(model):
            unit, source = item.metadata["unit"], item.metadata["source"]
            definition["properties"][item.name]["description"] = f"{unit}; {source}" if unit else source
    schema["$defs"] |= known
    properties = schema["$defs"]["TargetEntry"]["properties"]
    properties["settings"] |= {"anyOf": [*models, {"type": "object"}]}
    properties["model"] |= {"anyOf": [{"enum": [*there]}, {"type": "string"}]}
    del properties["model"]["type"]
    (bench,) = (one["properties"] for one in schema["$defs"].values() if "world" in one.get("properties", {}))
    del bench["world"]["default"]["physics"]  # that of this machine
    vehicle = schema["$defs"]["World"]["properties"]["vehicle"]
    vehicle["anyOf"] = [
        {"enum": [name for system in systems for name in system.vehicles]},
        {"type": vehicle.pop("type")},
    ]
    return schema
