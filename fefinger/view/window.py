"""The window of `fefinger view`: sliders over times and fields, and a box for every part."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.results.result_record import ResultRecord
from fefinger.support.checks import InputError
from fefinger.view import figures, frames, pictures, quantities, renderer
from fefinger.view.plot3d import FingerActor


if TYPE_CHECKING:
    from pyvista import Plotter


SIZE, MORE = (1300, 900), 500  # pixels, and pixels of width of a further result
ABOVE = (0.0, -0.12)  # shift of the finger, from -1 to 1 across and up, to make room for sliders
SLIDER: dict[str, Any] = {
    "color": figures.INK,
    "style": "modern",
    "title_height": 0.018,
    "slider_width": 0.02,
    "tube_width": 0.004,
}


class Controls:
    """The fingers in a plotter, and what its sliders and boxes do to all of them."""

    def __init__(
        self,
        plotter: "Plotter",
        results: Sequence[ResultRecord],
        field: str,
        *,
        time: float | None = None,
        limits: tuple[float, float] | None = None,
        folders: Sequence[str] = (),
    ) -> None:
        self.plotter, self.results, self.limits, self.folders = plotter, results, limits, folders
        self.actors: list[FingerActor] = pictures.compose(plotter, results, field, limits, folders)
        self.times = pictures.stored_times(self.actors)
        self.move(frames.peak_time(results[0]) if time is None else time)

    def move(self, time: float) -> None:
        """Show the stored frames next to a time in s."""
        self.time = time
        for actor in self.actors:
            actor.at(time)

    def step(self, number: float) -> None:
        """Show a stored time by its number from 1, as times are not evenly spaced."""
        self.move(float(self.times[min(max(round(number), 1), len(self.times)) - 1]))

    def toggle(self, part: str, on: bool) -> None:
        """Show or hide a part of every finger."""
        for actor in self.actors:
            actor.show(part, on)

    def color(self, field: str) -> None:
        """Color the fingers by another field; the camera stays unless the finger is cut anew."""
        before = self.actors
        if field == before[0].field:
            return
        camera = self.plotter.renderers[0].camera
        for title in list(self.plotter.scalar_bars.keys()):
            self.plotter.remove_scalar_bar(title)
        for actor in before:
            actor.remove()
        self.actors = pictures.compose(self.plotter, self.results, field, self.limits, self.folders)
        if self.actors[0].shown.whole == before[0].shown.whole:
            for column in range(len(before)):
                self.plotter.renderers[column].camera = camera
        self.move(self.time)
        for part in before[0].hidden:
            self.toggle(part, False)

    def add_widgets(self) -> None:
        """Add the sliders below and the boxes on the left."""
        times = self.times
        for column in range(len(self.actors)):
            self.plotter.renderers[column].camera.SetWindowCenter(*ABOVE)
        self.plotter.subplot(0, 0)
        if len(times) > 1:
            now = 1 + int(np.argmin(np.abs(times - self.time)))
            self.plotter.add_slider_widget(
                self.step, (1, len(times)),  # type: ignore[arg-type]  # pyvista's decorator loses self
                value=now, fmt="%.0f",
                title=f"stored time, 1 to {len(times)}",
                pointa=(0.2, 0.08), pointb=(0.48, 0.08), **SLIDER,
            )  # fmt: skip
        slider = self.plotter.add_text_slider_widget(
            self.color, list(quantities.FIELDS),  # type: ignore[arg-type]  # pyvista's decorator loses self
            value=quantities.FIELDS.index(self.actors[0].field),
            pointa=(0.54, 0.08), pointb=(0.82, 0.08), color=figures.INK, style="modern",
        )  # fmt: skip
        shape = slider.GetSliderRepresentation()
        shape.SetTubeWidth(SLIDER["tube_width"])
        shape.SetSliderWidth(SLIDER["slider_width"])
        shape.SetTitleHeight(SLIDER["title_height"])
        box = 22  # pixels of a box
        for row, part in enumerate(reversed(self.actors[0].parts)):
            at = 20.0 + row * (box + 10)
            self.plotter.add_checkbox_button_widget(
                partial(self.toggle, part),  # type: ignore[arg-type]  # pyvista's decorator loses self
                value=True, position=(14.0, at), size=box,
                border_size=2, color_on="#0072B2", color_off="#dfe5ea", background_color="white",
            )  # fmt: skip
            self.plotter.add_text(
                part, position=(14.0 + box + 10, at), font_size=10, color=figures.INK,
                name=f"box {part}",
            )  # fmt: skip


def show(
    results: ResultRecord | Sequence[ResultRecord],
    field: str = quantities.DEFAULT,
    time: float | None = None,
    limits: tuple[float, float] | None = None,
    folders: Sequence[str] = (),
) -> object:
    """Open a window, or a view inside a notebook, on one result or several side by side.

    Arguments as of `screenshot`. Returns what a notebook displays. Raises InputError if
    there is no renderer or no display, a result has no fields, or the time is after its end.
    """
    shown = frames.requested(results, field, time)
    renderer.require()
    size = (SIZE[0] + MORE * (len(shown) - 1), SIZE[1])
    plotter = renderer.plotter(size, len(shown), aside=pictures.BARS, off_screen=None)
    if not (plotter.notebook or plotter.off_screen or renderer.has_display()):
        raise InputError(
            "show: expected a display for the window, found none; "
            "use `fefinger view DIR --screenshot PNG` or `--html FILE`, or a notebook"
        )
    controls = Controls(plotter, shown, field, time=time, limits=limits, folders=folders)
    if not (plotter.notebook or plotter.off_screen):
        controls.add_widgets()
    return plotter.show()
