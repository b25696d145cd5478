"""Built-in scenes with published tissue, as most measurements and tests take them."""

from collections.abc import Mapping
from typing import Any

from fefinger.scene import builtin
from fefinger.scene.finger import Finger
from fefinger.scene.library import PUBLISHED
from fefinger.scene.scene import Scene


def load(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return a built-in scene of published tissue, which small strain answers within its limits."""
    return builtin.load(
        name, {"finger.tissue": PUBLISHED, "ask.rel_error": 0.4} | dict(changes or {})
    )


def subject(name: str, **values: Any) -> Finger:
    """Return the finger of a subject of the thesis, of published tissue."""
    return Finger.subject(name, **({"tissue": PUBLISHED} | values))
