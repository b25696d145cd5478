"""Records of a plan and of a result; `netcdf` saves and loads them."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.results.candidate import Candidate
from fefinger.results.harmonic import Harmonic
from fefinger.results.plan_text import choice_line, ladder
from fefinger.results.records import Fields, Lateral, Pad, Refusal, Response, Rung, Sites
from fefinger.scene.cautions import quasistatic, unmodeled, warnings
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains


@dataclass(frozen=True)
class Settings:
    """Settings of a run.

    resolution of the mesh, and half: whether half a finger is meshed, both None without a mesh;
    times: number of output times; computed: of "force", "pressure", "strain", "fields"; afferents:
    simulated types.
    """

    resolution: str | None
    half: bool | None
    times: int
    computed: tuple[str, ...]
    afferents: tuple[str, ...]

    @property
    def described(self) -> str:
        """What is computed, at how many times, and on which mesh, in a sentence."""
        mesh = ""
        if self.resolution is not None:
            half = "half a" if self.half else "the whole"
            mesh = f" on the {self.resolution} mesh of {half} finger"
        what = ", ".join(self.computed)
        fibers = f" and the spikes of {', '.join(self.afferents)}" if self.afferents else ""
        return f"It computes {what}{fibers} at {self.times} times{mesh}."


@dataclass(frozen=True)
class Plan:
    """The chosen mechanics, its settings, and all candidates that were compared.

    sentence: why it was chosen; overridden: refusals of a mechanics that the user named; machine:
    what the times of the rungs mean; trust: expected errors of the requested quantities, in words;
    tried: refusals of the mechanics that were chosen first and found the scene beyond their limits.
    """

    mechanics: str
    rungs: tuple[Rung, ...]
    sentence: str
    overridden: tuple[Refusal, ...] = ()
    settings: Settings | None = None
    machine: str = ""
    trust: str = ""
    tried: tuple[Refusal, ...] = ()

    def __repr__(self) -> str:
        """Show the choice, its reason, its expected errors, and the ladder."""
        rung = self.chosen
        parts = choice_line(rung), self.sentence, self.trust, ladder(self.rungs, rung)
        return "\n\n".join(filter(None, parts))

    @property
    def on(self) -> str:
        """Mechanics and mesh, as in "pressed on the standard mesh"."""
        mesh = self.settings.resolution if self.settings else None
        return Candidate(self.mechanics, mesh).on

    @property
    def chosen(self) -> Rung:
        """The rung of the chosen mechanics, on its mesh."""
        wanted = Candidate(self.mechanics, self.settings.resolution if self.settings else None)
        rungs = [rung for rung in self.rungs if rung.mechanics == self.mechanics]
        return next((rung for rung in rungs if rung.candidate == wanted), rungs[0])


@dataclass(frozen=True)
class ResultRecord:
    """Result of a scene: response of the mechanics, spikes, plan and provenance."""

    scene: Scene
    plan: Plan
    response: Response
    spikes: "SpikeTrains | None"
    status: str
    seconds: dict[str, float]
    provenance: dict[str, Any]

    @property
    def time(self) -> Array:
        """Times (n_t,) in s."""
        return self.response.time

    @property
    def depth(self) -> Array:
        """Travel of the indenter (n_t,) in mm, 0 at first touch."""
        return self.response.depth

    @property
    def force(self) -> Array | None:
        """Force of the whole finger (n_t,) in N, along the indenter's normal."""
        return self.response.force if self.scene.ask.force else None

    @property
    def peak(self) -> int:
        """Step of the largest force; where the force is prescribed, of the largest depth.

        A held force differs only by rounding from step to step, while the tissue creeps: then the
        deepest step is the end of the hold.
        """
        answer = self.scene.motion.control.of(self.response.force, self.depth)
        return int(np.argmax(answer))

    @property
    def peak_name(self) -> str:
        """The quantity that is largest at the step `peak`, in words."""
        return f"the largest {self.scene.motion.control.other}"

    @property
    def contact_area(self) -> Array | None:
        """Contact area (n_t,) in mm²."""
        return self.response.contact_area

    @property
    def centroid(self) -> Array | None:
        """Pressure centroid (n_t, 2) in mm (x, y)."""
        return self.response.centroid

    @property
    def lateral(self) -> Lateral | None:
        """Path, lateral force, stick and slip of an indenter that slides or grips."""
        return self.response.lateral

    @property
    def pad(self) -> Pad | None:
        """Points of the pad where the pressure is reported."""
        return self.response.pad

    @property
    def pressure(self) -> Array | None:
        """Contact pressure (n_t, n_pad) in kPa, positive in compression."""
        return self.response.pressure

    @property
    def sites(self) -> Sites | None:
        """The end-organ sites."""
        return self.response.sites

    @property
    def harmonic(self) -> Harmonic | None:
        """Response to small oscillations about the preload; None unless the motion is a sweep."""
        return self.response.harmonic

    @property
    def strain(self) -> Array | None:
        """Strain tensor (n_t, n_sites, 3, 3) at the sites, positive in tension.

        Small strain; logarithmic strain where `Response.finite`, as of `pressed` and `solid`.
        """
        return self.response.strain

    @cached_property
    def principal(self) -> tuple[Array, Array]:
        """Smallest and largest principal strain at the sites, (n_t, n_sites) each."""
        if self.strain is None:
            raise InputError("ask.strain: expected true for principal strains, received false")
        from fefinger.support.tensors import extremes  # compiled

        return extremes(self.strain)

    @property
    def green_lagrange(self) -> Array | None:
        """Green-Lagrange strain (n_t, n_sites, 3, 3) at the sites, where the strain is finite.

        E = (F'F - I) / 2 = (exp(2 H) - I) / 2, from the logarithmic strain H = ln(F'F) / 2 in
        `strain`, both in the directions of the undeformed finger. None where `strain` is small
        strain, for which the two measures agree.
        """
        if self.strain is None or not self.response.finite:
            return None
        values, vectors = np.linalg.eigh(self.strain)
        scaled = vectors * (np.expm1(2 * values) / 2)[..., None, :]
        return np.asarray(scaled @ np.swapaxes(vectors, -1, -2))

    @property
    def fields(self) -> Fields | None:
        """Fields on the mesh; None unless requested."""
        return self.response.fields

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about samples of the motion, and about its speed if inertia is left out."""
        of_motion = warnings(self.scene.motion)
        if self.response.inertia:
            return of_motion
        return of_motion + quasistatic(self.scene, self.time, self.depth)

    @property
    def unmodeled(self) -> tuple[str, ...]:
        """Types of units whose cause to fire is not in the mechanics (`scene.cautions`)."""
        spikes = self.spikes is not None and not self.response.inertia
        return unmodeled(self.scene) if spikes else ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Simplifications and choices that a reader of the result must know."""
        return self.response.notes + (self.spikes.notes if self.spikes is not None else ())
