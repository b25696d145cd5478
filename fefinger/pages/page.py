"""Self-contained HTML pages: a template and the style sheet of `templates/`, pictures inside."""

import base64
import re
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any
from urllib.parse import quote

from fefinger.support import text
from fefinger.view import figures


TEMPLATES = "fefinger.pages.templates"
PLAIN = " !$'()*+,-./:;=?@[]_{}|~"
"""Characters that stay unescaped in a data URL in double quotes; base64 is a quarter longer."""


def render(template: str, **values: Any) -> str:
    """Render a template of `templates/` with `values` and the style sheet."""
    from jinja2 import Environment, FunctionLoader

    environment = Environment(
        loader=FunctionLoader(source), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"percent": text.percent, "code": code}
    return environment.get_template(template).render(css=source("report.css"), **values)


def source(name: str) -> str:
    """Return a file of `templates/` as markup that is not escaped."""
    return raw(resources.files(TEMPLATES).joinpath(name).read_text("utf-8"))


def code(sentence: str) -> str:
    """Escape a sentence for a page, and set text between backticks as code."""
    from markupsafe import escape

    return raw(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(sentence))))


def raw(markup: str) -> str:
    """Mark text as markup that is not escaped; it has to be safe."""
    from markupsafe import Markup

    return Markup(markup)


def svg(drawn: Any) -> str:
    """Return a Figure as the source of a picture in a page, for an attribute in double quotes."""
    return raw("data:image/svg+xml," + quote(figures.svg(drawn), safe=PLAIN))


def png(data: bytes) -> str:
    """Return the bytes of a PNG file as the source of a picture in a page."""
    return "data:image/png;base64," + base64.b64encode(data).decode("ascii")


def flat(table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the entries of nested tables that are not empty, as (dotted name, text)."""
    return ((name, str(value)) for name, value in text.flat(table) if value != "")
