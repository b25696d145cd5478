"""HTML pages in one file, with their style sheet and pictures, from templates of `templates/`.

All templates extend `base.html`.
"""

import base64
import re
from importlib import resources
from typing import TYPE_CHECKING
from urllib.parse import quote

from fefinger.support import text
from fefinger.view import figures


if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEMPLATES = resources.files("fefinger.pages") / "templates"
PLAIN = " !$'()*+,-./:;=?@[]_{}|~"
"""Characters that need no escape in a data URL in double quotes; base64 is a quarter longer."""


def render(template: str, **values: object) -> str:
    """Render a template with values by name and the style sheet."""
    from jinja2 import Environment, FunctionLoader

    environment = Environment(
        loader=FunctionLoader(source), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"percent": text.percent, "code": code}
    return environment.get_template(template).render(css=source("report.css"), **values)


def source(name: str) -> str:
    """Return a file of `templates/` as markup that is not escaped."""
    return raw(TEMPLATES.joinpath(name).read_text("utf-8"))


def code(sentence: str) -> str:
    """Escape a sentence and mark its text between backticks as code."""
    from markupsafe import escape

    return raw(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(sentence))))


def raw(markup: str) -> str:
    """Mark text as safe markup, which is not escaped."""
    from markupsafe import Markup

    return Markup(markup)


def svg(drawn: "Figure") -> str:
    """Return a figure as the source of a picture, for an attribute in double quotes."""
    return raw("data:image/svg+xml," + quote(figures.svg(drawn), safe=PLAIN))


def png(data: bytes) -> str:
    """Return the bytes of a PNG file as the source of a picture."""
    return "data:image/png;base64," + base64.b64encode(data).decode("ascii")
