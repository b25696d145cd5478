"""`pressed`: a table of elastic solutions over depth, convolved with the relaxation of a motion.

Small motions about a preload: the stiffness k of a pressed finger is that of its material and a
smaller, negative one of the stress at rest, -s k. The first relaxes with G, the second does not: a
small motion x has the force k ((1 + s) G * x - s x), G being 1 at long times. So it relaxes as a
finger whose decaying weights are 1 + s times as large. So does a tabulated press, by its work
ratios. Its stiffness is corrected here (`PreloadRelaxation`), since its force between its depths is
interpolated without overshoot, and the slope of that is off by some percent.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fefinger.fem.body import solid
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.elements.probe import recovered_gradient_at
from fefinger.mechanics.press import elastic_press, finite_sliding, response
from fefinger.mechanics.press.depth_table import DepthTable
from fefinger.mechanics.press.elastic_press import FARTHEST
from fefinger.mechanics.press.placement import on_neighborhood, whole_pad
from fefinger.mechanics.press.problem import Press, SolutionMethod, frames_of, tissues, with_nail
from fefinger.mechanics.press.reference import reference_strain
from fefinger.mechanics.press.response import finite_strain_fields
from fefinger.mechanics.press.small_strain import WHOLE_MESH
from fefinger.neural.drives import Reference
from fefinger.results.records import Fields, Response
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress, Stages
from fefinger.support.tensors import logarithmic
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact import ting
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


METHOD: SolutionMethod = replace(
    WHOLE_MESH,
    body=lambda finger, mesh, report: solid(with_nail(finger, mesh), tissues(finger)),
)
"""Method of `pressed`: the solid alone, which is factored only to solve a new table."""

BESIDE = 0.02
"""Half the interval about the preload, relative to it, of the slope of the tabulated press.

A smaller vibration has its own: between two nodes of depth the slope is off by up to a fifth.
"""


@dataclass(frozen=True)
class TabulatedPress:
    """A contact problem (`Press`) and the table of its elastic solutions over depth.

    Its properties are the elastic quantities of the relaxed finger at the nodes of depth; its
    methods convolve them along the motion. contact: the candidate vertices that the pressures of
    the table belong to.
    """

    press: Press
    table: DepthTable
    contact: ContactSurface

    @classmethod
    def of(cls, press: Press, table: DepthTable) -> "TabulatedPress":
        """Find the candidate vertices of a table on the body of a contact problem."""
        body = press.body
        on = contact_surface(body.space, body.pad, body.normals, press.obstacle, table.reach)
        return cls(press, table, on)

    @cached_property
    def pressure(self) -> Array:
        """Elastic pressure (n_nodes, n_candidates) kPa at the nodes of depth."""
        return self.table.bounded(self.table.pressure)

    @cached_property
    def instantaneous(self) -> ting.ElasticForce:
        """Elastic force of the whole finger in N for its modulus at t = 0."""
        table = self.table
        force = self.table.force_at_nodes / self.press.finger.prony.long_time
        return ting.ElasticForce(table.nodes, force, table.measure, table.work_at_nodes)

    def elastic_force(self, depth: Array) -> Array:
        """Elastic force (n,) N of the whole finger at depths (n,) mm."""
        return np.interp(depth, self.table.nodes, self.table.force_at_nodes)

    def along(self, time: Array) -> ting.ContactHistory:
        """Solve the contact along the motion, at times (n_t,) s."""
        motion, table, prony = self.press.motion, self.table, self.press.finger.prony
        value = np.asarray(motion.value(time), dtype=np.float64)
        if motion.by_force:
            return ting.press_by_force(prony, time, value, self.instantaneous)
        return ting.press_by_depth(prony, time, value, table.nodes, table.measure)

    def forces(self, history: ting.ContactHistory) -> Array:
        """Force (n_t,) N: the prescribed one to the last digit."""
        if self.press.motion.by_force:
            return np.asarray(self.press.motion.value(history.time), dtype=np.float64)
        return self.instantaneous.along(history.stress_weights, history.depth)

    def pressures(self, history: ting.ContactHistory) -> Array:
        """Pressure (n_t, n_candidates) kPa: cut off at 0 and scaled to the force."""
        pushing = np.maximum(history.stress(self.pressure) / self.press.finger.prony.long_time, 0.0)
        unit = self.press.body.sides * NEWTON_PER_MILLINEWTON
        borne = unit * pushing @ self.contact.projected
        force = self.forces(history)
        factor = np.divide(force, borne, out=np.zeros_like(borne), where=borne > 0)
        return np.asarray(factor[:, None] * pushing)

    def moments(self, history: ting.ContactHistory) -> Array:
        """Moment (n_t, 3) mN mm of the meshed part, scaled to the force."""
        table, weights = self.table, history.stress_weights
        borne, force = weights @ self.table.force_at_nodes, self.forces(history)
        factor = np.divide(force, borne, out=np.zeros_like(borne), where=borne > 0)
        return np.asarray(factor[:, None] * (weights @ table.between @ table.moment))

    def strain(self, points: Array) -> Array:
        """Logarithmic strain (n, n_points, 3, 3) at points of the whole finger, at the depths."""
        body = self.press.body
        probe = recovered_gradient_at(body.space, body.folded(points), body.planes)
        gradients = self.table.unknowns(self.table.at_depths, probe.shape[1]) @ probe.T
        strain = logarithmic(gradients.reshape(len(gradients), -1, 3, 3))
        return body.unfolded(strain, points)

    def reference(self) -> Reference | None:
        """Strain at the central sites of the reference press, where spikes are requested."""
        plate = self.press.reference
        if plate is None:
            return None
        body = self.press.body
        return reference_strain(body, plate.sites, self.table.reference(body.space.n_unknowns))


def table_of(press: Press, stages: Stages) -> DepthTable:
    """Read or solve the table that a motion needs: to its depth, or to its force.

    Errors as `elastic_press.load_or_solve`, and InputError for a force that is too large.
    """
    motion = press.motion
    if motion.deepest is not None:
        return elastic_press.load_or_solve(press, motion.deepest, stages)
    table = elastic_press.load_or_solve(press, 0.0, stages, force=motion.peak)
    if table.force[-1] >= motion.peak:  # relaxed tissue bears the least
        return table
    raise InputError(
        f"motion.force: expected one that the relaxed finger bears at {FARTHEST:g} of its "
        f"thickness of {press.finger.thickness:g} mm or before, received {motion.peak:g} N, where "
        f"it bears {table.force[-1]:.3g} N; press less"
    )


def respond(
    scene: Scene, progress: Progress | None = None, *, mechanics: str, notes: tuple[str, ...]
) -> Response:
    """Answer the scene from its table over depth, which is cached, or solved now and cached.

    Errors as `mechanics.pressed.respond`.
    """
    stages = Stages(progress)
    press = Press.of(scene, METHOD, stages, mechanics=mechanics, notes=notes)
    tabulated = TabulatedPress.of(press, table_of(press, stages))
    with stages.stage("motion"):
        history = tabulated.along(press.time)
    return tabulated_response(tabulated, history, stages)


def tabulated_response(
    tabulated: TabulatedPress, history: ting.ContactHistory, stages: Stages
) -> Response:
    """Return the Response of a contact problem whose table is convolved along its motion."""
    press = tabulated.press
    table, quantities = tabulated.table, {}
    strained = history.strain_weights @ table.between
    with stages.stage("fields"):
        fields = _fields(tabulated, history, strained) if press.fields else None
    with stages.stage("pressure"):
        pressure = tabulated.pressures(history)
        gaps = _gaps(table, history.depth, strained)
        penetration = response.deepest_penetration(gaps)
        if press.pressure:
            seen = tabulated.contact.neighborhood
            pad, column = whole_pad(press.body, seen)
            quantities = response.of_pressure(
                pad,
                on_neighborhood(pressure, seen)[:, column],
                np.interp(history.edge, table.nodes, table.bounded(table.area)),
                gaps[:, column],
                tabulated.moments(history),
                press.body.half,
            )
    with stages.stage("strain"):
        strain = None
        if press.sites is not None:
            strain = np.tensordot(strained, tabulated.strain(press.sites.points), 1)
        reference = tabulated.reference()
    return response.make_response(
        press,
        stages,
        len(tabulated.contact),
        penetration,
        notes=finite_sliding.notes(press),
        time=press.time,
        depth=history.depth,
        force=tabulated.forces(history),
        strain=strain,
        reference=reference,
        fields=fields,
        status=(
            f"Solved: an elastic press of {len(table.depth) - 1} depths up to {table.deepest:.3g} "
            f"mm, and its relaxation at {len(press.time)} times; {response.exactness(penetration)}."
        ),
        lateral=finite_sliding.frictionless_plate(press, press.time) if press.tangential else None,
        **quantities,
    )


def _gaps(table: DepthTable, depth: Array, strained: Array) -> Array:
    """Gaps (n_t, n_seen) mm: those at rest, less the travel, plus the displacement of the skin.

    depth (n_t,) mm; strained (n_t, n): weights of the depths of the table.
    """
    yielded = table.gap + table.depth[:, None] - table.gap[0]
    return np.asarray(table.gap[0] - depth[:, None] + strained @ yielded)


def _fields(tabulated: TabulatedPress, history: ting.ContactHistory, strained: Array) -> Fields:
    """Fields on the mesh at some of the times; strained as in `_gaps`."""
    press = tabulated.press
    pressure, force = tabulated.pressures(history), tabulated.forces(history)
    frames = frames_of(history.depth, int(np.argmax(force)))
    amplitudes = strained[frames] @ tabulated.table.at_depths
    states = tabulated.table.unknowns(amplitudes, press.body.space.n_unknowns)
    vertices = tabulated.contact.on.vertices
    return finite_strain_fields(press, press.time[frames], states, vertices, pressure[frames])


def about_preload(finger: Finger, share: float) -> Finger:
    """Return a finger that relaxes as small motions about its preload.

    share: s, the stiffness of the material over the whole one, less 1.
    """
    whole, *decaying = finger.prony.weights
    weights = np.array([whole, *((1.0 + share) * weight for weight in decaying)])
    prony = Prony(tuple((weights / weights.sum()).tolist()), finger.prony.v)
    return replace(finger, prony=prony)


@dataclass(frozen=True)
class PreloadRelaxation:
    """Correction of the stiffness of a tabulated press about a preload, along a vibration.

    table: the press; share: s; preload mm; stiffness N/mm of the relaxed finger there.
    """

    table: TabulatedPress
    share: float
    preload: float
    stiffness: float

    def force(self, motion: Motion, time: Array) -> Array:
        """Change (n_t,) of the force in N at prescribed depth, at times (n_t,) in s."""
        depth, vibration = motion.value(time), motion.vibration(time)
        at, slow = (self.table.elastic_force(x) for x in (depth, depth - vibration))
        swing, prony = np.asarray(at - slow), self.table.press.finger.prony
        relaxing = hereditary_integral(prony, time, swing) / prony.long_time
        stiffer = self.stiffness / self._tabulated_stiffness(float(np.abs(vibration).max()))
        return np.asarray((stiffer - 1.0) * ((1.0 + self.share) * relaxing - self.share * swing))

    def depth(self, motion: Motion, time: Array) -> Array:
        """Change (n_t,) of the depth in mm at prescribed force, at times (n_t,) in s."""
        swing = motion.vibration(time)
        prony = about_preload(self.table.press.finger, self.share).prony
        moved = prony.long_time * creep_integral(prony, time, swing) / self.stiffness
        covered = float(np.abs(swing).max()) / self.stiffness
        return np.asarray(moved * (1.0 - self.stiffness / self._tabulated_stiffness(covered)))

    def _tabulated_stiffness(self, covered: float) -> float:
        """Stiffness in N/mm of the tabulated press within a vibration of some mm at the preload."""
        widest = BESIDE * self.preload
        beside = min(covered, widest) or widest
        low = self.preload - beside
        high = min(self.preload + beside, self.table.table.deepest)
        softer, harder = self.table.elastic_force(np.array([low, high])).tolist()
        return float((harder - softer) / (high - low))
