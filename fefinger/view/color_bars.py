"""Color bars of all actors of a plotter, in a separate column on the right."""

from collections.abc import Sequence
from typing import Any

from fefinger.view import figures
from fefinger.view.plot3d import FingerActor, Prop


WIDTH = 260  # pixels of the column
LOOK: dict[str, Any] = {
    "color": figures.INK,
    "vertical": True,
    "position_x": 0.3,
    "width": 0.32,
    "height": 0.2,
    "fmt": "%.3g",
    "n_labels": 5,
    "title_font_size": 21,
    "label_font_size": 21,
    "unconstrained_font_size": True,
}
PLACES = (0.7, 0.43, 0.16)  # of their lower ends: at most a field, the pressure and the rate
LONG = 23  # letters of a title in one line


def add_bars(plotter: Any, actors: Sequence[FingerActor]) -> None:
    """Add one bar for each thing that any actor is colored by; the last actor keeps them."""
    keys = {label: key for actor in reversed(actors) for label, key in actor.keys.items()}
    plotter.subplot(0, len(actors))
    for place, label in zip(PLACES, actors[0].keys | keys, strict=False):
        title = (label if len(label) <= LONG else label.replace(" / ", "\n/ ")) + "\n"
        mapper, needs = keys[label]
        bar = plotter.add_scalar_bar(
            title=title, mapper=mapper, position_y=place, **LOOK, render=False
        )
        actors[-1].props.append(Prop(bar, needs))
    actors[-1].refresh()
