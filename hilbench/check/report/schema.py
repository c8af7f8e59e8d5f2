"""The JSON report and its published schema, both from `hilbench.check.results`."""

from __future__ import annotations

from typing import Any

import msgspec

from hilbench.check.results import FORMAT, Report
from hilbench.files.names import escaped_all
from hilbench.strict.schema import json_schema


def report_json(report: Report) -> str:
    """Return the report as indented JSON."""
    return msgspec.json.format(msgspec.json.encode(escaped_all(msgspec.to_builtins(report))), indent=2).decode()


def report_schema() -> dict[str, Any]:
    """Return the JSON Schema of the report."""
    return json_schema(Report, FORMAT)
