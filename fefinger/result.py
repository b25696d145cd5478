"""Result of a scene: `save` writes a folder of files that other programs read, `load` reads it.

    result.nc      everything: labeled arrays with units, the scene (TOML), the plan (JSON)
    result.vtkhdf  the fields on the mesh as a VTK time series, for ParaView and PyVista
    spikes.csv     one row per spike
    units.csv      one row per afferent unit, silent ones too
    report.html    the report

Files are written into a hidden folder beside their final place and moved when all are complete.
"""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Self

from fefinger.afferents import of_units, reduced
from fefinger.results.key_numbers import rows
from fefinger.results.result_record import ResultRecord, left_out
from fefinger.scene.cautions import quasistatic, samples, unmodeled, warnings
from fefinger.scene.finger import origin_notes, other_size
from fefinger.support.atomic_write import keep, output_folder
from fefinger.support.checks import InputError
from fefinger.support.compiled import notice
from fefinger.support.interrupt import shielded
from fefinger.support.machine import software
from fefinger.support.registry import AFFERENTS
from fefinger.support.text import table


if TYPE_CHECKING:
    import xarray as xr

    from fefinger.neural.trains import SpikeTrains
    from fefinger.results.records import Response
    from fefinger.results.result_record import Plan
    from fefinger.scene.scene import Scene


NOT_HARMONIC = (
    "No harmonic response to the sweep: `modal` alone computes one. It is chosen where inertia "
    "matters, or by name (--mechanics modal)."
)
"""Note on a sweep that another mechanics than `modal` has answered."""

BEYOND = "{0} was chosen first, and found the scene beyond its limits: {1}."
"""Note on a mechanics that another one has answered instead of."""

NAMES = ("result.nc", "result.vtkhdf", "spikes.csv", "units.csv", "report.html")
"""Files of a saved result."""

PARTS = {
    "result.vtkhdf": ("Fields", "points"),
    "spikes.csv": ("SpikeTrains", "times"),
    "units.csv": ("SpikeTrains", "times"),
}
"""Files of parts that a result may lack, and an array of the part by which `result.nc` shows it."""


class Result(ResultRecord):
    """Result of a scene: response of the mechanics, spikes, plan and provenance."""

    @classmethod
    def of(
        cls,
        scene: "Scene",
        plan: "Plan",
        response: "Response",
        spikes: "SpikeTrains | None" = None,
        seconds: Mapping[str, float] | None = None,
    ) -> Self:
        """Assemble the result from the outputs of the stages of a run.

        `seconds`: of the stages after the mechanics. Notes are added on parts of the
        finger that belong to another one, on motions that are too fast for statics, and on compiled
        code that cannot be kept. Strain that was computed for the spikes alone is left out; where
        the scene leaves `ask.strain` open, it is kept at one end organ of each unit.
        """
        notes = origin_notes(scene.finger) + other_size(scene.finger)
        notes += warnings(scene.motion) + samples(scene.motion)
        if scene.motion.frequencies is not None and response.harmonic is None:
            notes += (NOT_HARMONIC,)
        if not response.inertia:
            notes += quasistatic(scene, response.time, response.depth)
        notes += left_out(scene.ask, plan.mechanics) + ((notice(),) if notice() else ())
        notes += tuple(BEYOND.format(each.mechanics, each.reason) for each in plan.tried)
        if not scene.ask.wants("strain"):
            response = replace(response, strain=None)
        elif scene.ask.strain is None:
            response = of_units(response)
        scene_hash = hashlib.sha256(scene.to_toml().encode()).hexdigest()
        apart = () if response.inertia else unmodeled(scene)
        fired = f" Spikes: {spikes.summary(apart)}." if spikes is not None else ""
        return cls(
            scene=scene,
            plan=plan,
            response=replace(response, notes=response.notes + notes),
            spikes=spikes,
            status=f"{response.status}{fired}",
            seconds={**response.seconds, **(seconds or {})},
            provenance={**software(), "scene_sha256": scene_hash, **response.sources},
        )

    def __repr__(self) -> str:
        """Show the numbers that matter and their errors, not the arrays."""
        lines = table([*rows(self), ("computed", f"by {self.plan.on}")])
        return f"Result of {self.scene.name}\n{lines}"

    def fire(self, trial: int = 0) -> "SpikeTrains":
        """Return the spikes of the same units in another trial, without solving the scene again.

        Places, end organs and gains stay; noise and jitter follow from the trial, a whole number
        of 0 or more. `spikes` has the scene's trial, 0 unless `ask.trial` says otherwise. The
        counts are not checked by a finer step or another mesh, as in `spikes`.

        Raises
        ------
        InputError
            A result without spikes, or without strain at the end organs (`ask.strain`).
        """
        from fefinger.afferents import fire

        if not self.scene.ask.spikes or self.spikes is None:
            raise InputError("ask.spikes: expected the types of units to fire, received none")
        again = None
        if AFFERENTS[self.scene.ask.afferents].by_input:
            again = self.spikes
        elif not self.scene.ask.wants("strain") or reduced(self.response):
            msg = "ask.strain: expected true for further trials, which are fired from the strain"
            raise InputError(f"{msg}; run the scene again")
        ask, since = replace(self.scene.ask, trial=trial), self.scene.motion.recorded_from
        return fire(ask, self.response, since=since, again=again, check=False)

    def to_xarray(self) -> "xr.Dataset":
        """Return all that `result.nc` holds as a Dataset with units."""
        from fefinger.results.netcdf import dataset

        return dataset(self)

    def save(self, folder: str | PathLike[str]) -> list[str]:
        """Write the result into `folder` and return the paths written, `result.nc` first.

        `result.vtkhdf` needs fields, `spikes.csv` and `units.csv` need spikes. The files of an
        earlier result in the folder are replaced or removed. An interruption or an error leaves
        the folder as it was.

        Raises
        ------
        InputError
            A folder that cannot be written, that is full, or that holds files of these names which
            hold no result.
        """
        from fefinger.pages import report
        from fefinger.results import netcdf
        from fefinger.support import atomic_write

        target = output_folder(folder)
        before = earlier(target)
        saving = atomic_write.temporary_folder(target, atomic_write.SAVING)
        with atomic_write.as_input_error(target), saving as scratch:
            new = {name: scratch / name for name in NAMES}
            new["result.nc"].write_bytes(atomic_write.netcdf(netcdf.dataset(self)))
            if self.fields is not None:
                netcdf.write_vtkhdf(self.fields, new["result.vtkhdf"])
            if self.spikes is not None:
                self.spikes.to_csv(new["spikes.csv"])
                self.spikes.units_to_csv(new["units.csv"])
            report.write(self, new["report.html"])
            with shielded():  # a signal leaves the earlier result or this one, but no mixture
                for name, path in new.items():
                    if path.exists():
                        os.replace(path, target / name)
                    elif name in before:
                        (target / name).unlink(missing_ok=True)
        return [str(target / name) for name in NAMES if (target / name).exists()]

    def show(self) -> object:
        """Open the strain field in a PyVista window, or inline in a notebook."""
        from fefinger.view import show

        return show(self)


def earlier(folder: str | PathLike[str]) -> tuple[str, ...]:
    """Return the names of the files of the result that is saved in `folder`; none without one.

    Raises InputError when the folder has files of these names that the result there, if any, does
    not hold: the user or another command wrote them, and they stay.
    """
    from fefinger.results import netcdf
    from fefinger.results.labels import LAYOUT

    place = Path(folder)
    stored = netcdf.stored(place / "result.nc")
    present = [name for name in NAMES if os.path.lexists(place / name)]
    foreign = present
    if stored is not None:
        others = {name for name, key in PARTS.items() if LAYOUT[key].name not in stored}
        if (place / "study.json").exists():
            others.add("report.html")  # of the study
        foreign = [name for name in present if name in others]
    keep(foreign, place, "result")
    return tuple(present)


def load(path: str | PathLike[str]) -> Result:
    """Return the Result that `save` has written, from its folder or its `result.nc`.

    Raises InputError where there is no such file, or it is damaged or not of fefinger.
    """
    from fefinger.results.netcdf import read

    return Result(**vars(read(path)))
