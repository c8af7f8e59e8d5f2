"""Renders a page from the template of a package: jinja2 escapes all that it shows, and a name that is missing fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.files.names import escaped

__all__ = ["TEMPLATE", "rendered"]

TEMPLATE = "page.html.j2"


def rendered(package: str, filters: Mapping[str, Callable[..., str]], values: Mapping[str, object]) -> str:
    """Return the page, with what is no text escaped.

    Args:
        package: whose template ``page.html.j2`` is.
        filters: what the template calls by these names.
        values: what the template shows.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader(package, "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(filters)
    return escaped(environment.get_template(TEMPLATE).render(values))
