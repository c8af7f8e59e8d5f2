"""JSON Schema of a msgspec model, with the explanations of its docstrings where editors show them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import msgspec

DATA_FOLDER = Path(__file__).parent.parent / "data"

_ATTRIBUTE = re.compile(r"^\s*(\w+): ")


def json_schema(model: type, title: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a model; unknown keys are refused throughout."""
    schema = msgspec.json.schema(model)
    for definition in schema["$defs"].values():
        if "properties" in definition:
            definition["additionalProperties"] = False
            _explain(definition)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **schema}


def schema_text(schema: dict[str, Any]) -> str:
    """Return a schema as it is published: indented, with a line end."""
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def _explain(definition: dict[str, Any]) -> None:
    """Split a docstring into the first paragraph, for the whole, and the lines about attributes, for each."""
    whole, _, attributes = definition.get("description", "").partition("Attributes:\n")
    definition["description"] = " ".join(whole.split("\n\n", maxsplit=1)[0].split())
    name = ""
    texts: dict[str, str] = {}
    for line in attributes.splitlines():
        if started := _ATTRIBUTE.match(line):
            name = started[1]
            texts[name] = line[started.end() :]
        elif name:
            texts[name] += f" {line.strip()}"
    for name, described in definition["properties"].items():
        if name in texts:
            described.setdefault("description", texts[name].strip())
