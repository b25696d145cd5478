"""Record of a study: its rows, its failures, and the inputs that reproduce it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fefinger.pages.page import flat


if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class StudyRows:
    """The rows of a study in the order of its grid.

    name of the scene; over: the columns of the grid; rows: one per scene and time; failures:
    (values of the grid, sentence); scenes: their number; reused: the number that were finished
    before; about: the inputs of the study and its provenance.
    """

    name: str
    over: tuple[str, ...]
    rows: tuple[dict[str, Any], ...]
    failures: tuple[tuple[dict[str, Any], str], ...]
    scenes: int
    reused: int
    about: dict[str, Any]

    def __repr__(self) -> str:
        """Show the grid and the numbers of scenes, not the rows."""
        grid = ", ".join(f"{name} ({len(each)})" for name, each in self.about["grid"].items())
        done = self.scenes - len(self.failures)
        return f"<Study of {self.name} over {grid}: {done} of {self.scenes} scenes answered>"

    def table(self) -> "pd.DataFrame":
        """Make a table with one row per scene and time, and units in the names of its columns.

        Its `attrs` hold the inputs of the study.
        """
        import pandas as pd

        plain = [{k: v for k, v in row.items() if not isinstance(v, list)} for row in self.rows]
        columns = list(dict.fromkeys(key for row in plain for key in row))
        table = pd.DataFrame(plain, columns=columns)
        table.attrs = {"scene": self.name, **dict(flat(self.about))}
        return table
