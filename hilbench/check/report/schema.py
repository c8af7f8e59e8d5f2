"""The JSON report and its published schema, both from `hilbench.check.results`."""

from __future__ import annotations

import json
from typing import Any

import msgspec

from hilbench.check.results import FORMAT, Report

SCHEMA_FILE = "report.schema.json"


def report_json(report: Report) -> str:
    """Return the report as indented JSON."""
    return msgspec.json.format(msgspec.json.encode(report), indent=2).decode()


def report_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the report."""
    schema = msgspec.json.schema(Report)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": FORMAT, **schema}


def schema_text(schema: dict[str, Any]) -> str:
    """Return a schema as it is committed: indented, with a line end."""
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
