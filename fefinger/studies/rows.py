"""The record of a study: its rows, what failed, and what it takes to ask the same again."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fefinger.pages.page import flat


if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class StudyRows:
    """The rows of a study in the order of its grid.

    name of the scene; over: the columns of the grid; rows: one per scene and time; failures:
    (values of the grid, sentence); scenes: how many there are; reused: how many were finished
    before; about: what it takes to ask the same again.
    """

    name: str
    over: tuple[str, ...]
    rows: tuple[dict[str, Any], ...]
    failures: tuple[tuple[dict[str, Any], str], ...]
    scenes: int
    reused: int
    about: dict[str, Any]

    def table(self) -> "pd.DataFrame":
        """Return a table with one row per scene and time, units in the names of its columns.

        Its `attrs` say how to make it again.
        """
        import pandas as pd

        plain = [{k: v for k, v in row.items() if not isinstance(v, list)} for row in self.rows]
        columns = list(dict.fromkeys(key for row in plain for key in row))
        found = pd.DataFrame(plain, columns=columns)
        found.attrs = {"scene": self.name, **dict(flat(self.about))}
        return found
