"""The Response of a press with inertia: of tissue that does not stiffen, and of tissue that does.

Tissue that stiffens with strain is taken as linear about the depth at which the motion vibrates:
its moduli are multiplied such that the static stiffness there is that of the tabulated press of
finite strain (`tabulated_press`), and it relaxes as motions about that preload do
(`PreloadRelaxation`). What inertia changes in that linear finger, the difference of its answers
with and without, is added to the quasi-static answer at finite strain. It is a part of the answer,
and is computed on the next coarser mesh, whose modes take a fifth of the time.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fefinger.contact.complementarity import Complementarity
from fefinger.contact.oscillators import Oscillators
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.probe import strain_at_vertices
from fefinger.mechanics.press import mesh_limits, modal_press, operator, problem, tabulated_press
from fefinger.mechanics.press.frequency_response import Vibrating, about
from fefinger.mechanics.press.modal_body import stiffened
from fefinger.mechanics.press.modal_press import ModalHistory, TimeGrid
from fefinger.mechanics.press.notes import stiffens
from fefinger.mechanics.press.operator_cache import MESH_OF_INERTIA
from fefinger.mechanics.press.problem import Press, SmallStrainHistory
from fefinger.mechanics.press.reference import reference_of
from fefinger.mechanics.press.response import (
    interpolation,
    small_strain_fields,
    small_strain_response,
)
from fefinger.mechanics.press.small_strain import quasistatic, solve_contact
from fefinger.mechanics.press.tabulated_press import PreloadRelaxation, TabulatedPress
from fefinger.results.records import Fields, Harmonic, Response
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress, Stages
from fefinger.support.tensors import tensor_from_voigt
from fefinger.support.text import percent
from fefinger.support.units import NEWTON_PER_MILLINEWTON


SOFT = 1, 2  # labels of skin and subcutaneous tissue


def respond(
    scene: Scene,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    geometric_share: Callable[[float], float],
) -> Response:
    """Answer the scene with inertia.

    geometric_share: stiffness of the material over the whole one, less 1, of tissue that stiffens,
    by the depth over the thickness.

    Errors as `mechanics.modal.respond`.
    """
    stages = Stages(progress)
    grid = modal_press.modal_grid(scene.motion, fast="FAII" in scene.ask.spikes)
    if stiffens(scene.finger):
        return _corrected(scene, grid, stages, mechanics, notes, geometric_share)
    press = Press.of(scene, operator.METHOD, stages, mechanics=mechanics, notes=notes)
    # First guess of the depth that a force reaches, over the thickness: the operator ends at the
    # sides of the finger, which a larger guess may reach for nothing.
    shallow = 0.12
    press = replace(press, foreseen=shallow * press.finger.thickness)
    history = modal_press.solve_modal(press, grid, stages)
    press, body, contact = modal_press.at_stored(press, grid), history.body, history.contact
    with stages.stage("reference"):
        reference = reference_of(press, body.static, float(contact.depth.max()))
    small = SmallStrainHistory(body.complete, contact, reference)  # rest and modes side by side
    answer = small_strain_response(replace(press, fields=False), small, stages)
    with stages.stage("fields"):
        fields = None
        if press.fields:
            solve = partial(modal_press.displacements, press, history, scale=1.0)
            fields = small_strain_fields(press, contact, body.static.patch, solve)
    answer = _with_modes(replace(answer, fields=fields), history, grid)
    return _swept(answer, scene, press, history, 1.0, stages)


def _corrected(
    scene: Scene,
    grid: TimeGrid,
    stages: Stages,
    mechanics: str,
    notes: tuple[str, ...],
    geometric_share: Callable[[float], float],
) -> Response:
    """Answer at finite strain, with what inertia changes in a linear finger of its stiffness."""
    slow = Press.of(scene, tabulated_press.METHOD, stages, mechanics=mechanics, notes=notes)
    slow = modal_press.at_stored(slow, grid)
    table = TabulatedPress.of(slow, tabulated_press.table_of(slow, stages))
    with stages.stage("motion"):
        shares = table.along(slow.time)
    answer = tabulated_press.tabulated_response(table, shares, stages)
    depth = float(scene.motion.steady_level)  # about which it vibrates, or else its largest
    if scene.motion.by_force:  # of relaxed tissue, which a quick press does not reach
        depth = float(np.interp(depth, table.table.force_at_nodes, table.table.nodes))
        depth = min(depth, float(answer.depth.max()))
    else:
        depth = min(depth, table.table.deepest)
    share = geometric_share(depth / scene.finger.thickness)
    swinging = tabulated_press.about_preload(scene.finger, share)
    swinging = replace(swinging, resolution=MESH_OF_INERTIA[scene.finger.mesh])
    scene_about = replace(scene, finger=swinging)
    press = Press.of(scene_about, operator.METHOD, stages, mechanics=mechanics, notes=notes)
    press = replace(press, sites=answer.sites, foreseen=float(answer.depth.max()))
    factor = stiffening(press, table, depth)
    history = modal_press.solve_modal(press, grid, stages, factor)
    press = modal_press.at_stored(press, grid)
    linear = _Linear(press, history, _still(press, factor, stages), factor)
    relaxation = PreloadRelaxation(table, share, depth, tangent(table, depth))
    answer = _with_modes(_added(answer, linear, depth, relaxation), history, grid)
    answer = _swept(answer, scene, press, history, factor, stages, depth)
    if answer.harmonic is None:
        return answer
    preload = float(table.elastic_force(np.array(depth)))
    return replace(answer, harmonic=replace(answer.harmonic, preload_force=preload))


def _swept(
    answer: Response,
    scene: Scene,
    press: Press,
    history: ModalHistory,
    factor: float,
    stages: Stages,
    depth: float | None = None,
) -> Response:
    """Add the harmonic answer about the preload, where the motion is a sweep.

    factor: on the moduli; depth in mm of the preload, where the linear finger has another.
    """
    motion, level, deepest = scene.motion, scene.motion.steady_level, float(answer.depth.max())
    if motion.frequencies is None:
        return answer
    solid = modal_press.operator_of(press)
    by_force = depth is None and motion.by_force
    with stages.stage("harmonic"):
        harmonic = about(
            lambda on_pad, reach: Vibrating.of(
                *(press.finger, solid, history.modes, on_pad, reach, answer.sites, factor)
            ),
            *(solid, press.obstacle, deepest, motion.frequencies),
            depth=None if by_force else depth or level,
            force=level if by_force else None,
        )
    notes = (*answer.notes, *harmonic.notes, *_loses(harmonic, scene))
    return replace(answer, harmonic=harmonic, notes=notes)


def _loses(harmonic: Harmonic, scene: Scene) -> Iterator[str]:
    """Yield the note that the contact of a preload opens within a cycle, if it does."""
    amplitude = float(getattr(scene.motion, "amplitude", 0.0))
    lost = harmonic.frequency[amplitude * np.abs(harmonic.stiffness) > harmonic.preload_force]
    if not scene.motion.by_force and len(lost):
        yield (
            f"From {lost.min():.3g} to {lost.max():.3g} Hz the force of {amplitude:g} mm exceeds "
            f"the preload of {harmonic.preload_force:.3g} N: contact opens in mid-cycle, which the "
            "answer through time follows and the harmonic one does not."
        )


def stiffening(press: Press, table: TabulatedPress, depth: float) -> float:
    """Return the static stiffness at a depth in mm over the small-strain finger's.

    InputError where a mesh resolves no contact there.
    """
    body = press.body
    on_pad = patch(body.space, body.pad, body.normals, press.obstacle, problem.REACH * depth)
    reduced = press.method.reduce(body, on_pad, modal_press.probe_of(replace(press, sites=None)))
    active = np.flatnonzero(
        Complementarity(reduced.flexibility).solve(on_pad.gap - depth * on_pad.projected) > 0
    )
    projected = on_pad.projected[active]
    block = reduced.flexibility[np.ix_(active, active)]
    linear = body.sides * NEWTON_PER_MILLINEWTON * projected @ np.linalg.solve(block, projected)
    stiffness = tangent(table, depth)
    if not (len(active) and stiffness > 0):
        raise InputError(mesh_limits.unresolved(depth))
    return float(stiffness / linear)


def tangent(table: TabulatedPress, depth: float) -> float:
    """Return the static stiffness in N/mm at a depth in mm, by splines as of displacements."""
    from scipy.interpolate import CubicSpline

    press = table.table
    root = np.sqrt(depth)
    slope = CubicSpline(np.sqrt(press.depth), press.force)(root, 1)
    return float(slope / (2 * root))


def _still(press: Press, factor: float, stages: Stages) -> SmallStrainHistory:
    """Return the linear finger without inertia, at the times of the press."""
    reduced, contact = solve_contact(
        press,
        stages,
        lambda press, soft, *steps: quasistatic(press, stiffened(soft, factor), *steps),
    )
    return SmallStrainHistory(stiffened(reduced, factor), contact, None)


@dataclass(frozen=True)
class _Linear:
    """A linear finger of `factor` times the moduli, with inertia (`history`) and without."""

    press: Press
    history: ModalHistory
    still: SmallStrainHistory
    factor: float


def _added(
    answer: Response, linear: _Linear, depth: float, relaxation: PreloadRelaxation
) -> Response:
    press, history, still = linear.press, linear.history, linear.still
    unit = press.body.sides * NEWTON_PER_MILLINEWTON
    moving = unit * history.contact.pressure @ history.body.static.patch.projected
    resting = unit * still.contact.pressure @ still.reduced.patch.projected
    by_force, about = press.motion.by_force, (press.motion, press.time)
    force, more = answer.force, np.zeros_like(answer.force)
    if by_force:
        more = history.contact.depth - still.contact.depth + relaxation.depth(*about)
    else:
        force = force + moving - resting + relaxation.force(*about)
    # The linear finger is as stiff as at its preload, and leaves the object later than the skin.
    apart = (answer.force <= 0) & (not by_force)
    touches, pulls = apart & (moving > 0), ~apart & (force < 0)
    force = np.where(apart, 0.0, np.maximum(force, 0.0))
    share = np.divide(force, answer.force, out=np.zeros_like(force), where=answer.force > 0)
    notes = [
        f"Tissue stiffens with strain: inertia is that of a linear finger with {linear.factor:.3g} "
        f"times the moduli, of the stiffness at {depth:.3g} mm, on the {press.finger.mesh} mesh; "
        "its change of force, strain and displacement is added to the answer of `pressed`, and "
        "pressures are scaled to the force. The stress of the preload does not relax in the "
        f"vibration: {percent(relaxation.share)} more of the stiffness does than without it.",
    ]
    if pulls.any():
        notes.append(f"The contact would pull at {int(pulls.sum())} times: there it is open.")
    if touches.any():
        notes.append(
            f"At {int(touches.sum())} times the linear finger still touches the object where the "
            "skin without inertia does not: there the contact is open."
        )
    return replace(
        answer,
        depth=answer.depth + more,
        force=force,
        pressure=None if answer.pressure is None else share[:, None] * answer.pressure,
        moment=None if answer.moment is None else share[:, None] * answer.moment,
        contact_area=_open(answer.contact_area, force),
        centroid=_open(answer.centroid, force, np.nan),
        strain=_strain(answer, linear),
        fields=_fields(answer, linear, share),
        notes=(*answer.notes, *notes),
        numbers=answer.numbers | {"finite_strain": 1.0, "stiffening": linear.factor},
    )


def _strain(answer: Response, linear: _Linear) -> Array | None:
    """Strain (n_t, n_sites, 3, 3) of the answer with the change of it by inertia, if any is."""
    press, history, still = linear.press, linear.history, linear.still
    if answer.strain is None or press.sites is None:
        return answer.strain
    change = history.contact.elastic_pressure @ history.body.complete.strain_operator.T
    change -= still.contact.elastic_pressure @ still.reduced.strain_operator.T
    return answer.strain + press.unfolded(tensor_from_voigt(change.reshape(len(change), -1, 6)))


def _open(values: Array | None, force: Array, empty: float = 0.0) -> Array | None:
    """Values (n_t, ...) of a contact, `empty` where it bears no force."""
    if values is None:
        return None
    closed = (force > 0).reshape(-1, *[1] * (values.ndim - 1))
    return np.where(closed, values, empty)


def _fields(answer: Response, linear: _Linear, share: Array) -> Fields | None:
    """Return the fields at finite strain with what inertia adds, interpolated between the meshes.

    share (n_t,): the force over that without inertia.
    """
    press, still, factor, fields = linear.press, linear.still, linear.factor, answer.fields
    if fields is None:
        return None
    frames = np.searchsorted(press.time, fields.times)
    added = modal_press.displacements(press, linear.history, frames, factor)
    loads = still.reduced.patch.loads @ still.contact.elastic_pressure[frames].T
    added -= operator.METHOD.unknowns(modal_press.operator_of(press), np.asarray(loads)) / factor
    space, count = press.body.space, len(frames)
    moved, strain = fields.displacement.copy(), fields.strain.copy()
    soft = np.unique(fields.cells[np.isin(fields.region, SOFT)])
    to = interpolation(space, fields.points[soft])
    for field, change, width in (
        (moved, added[: 3 * len(space.points)], 3),
        (strain, strain_at_vertices(space) @ added, 6),
    ):
        at_vertices = change.reshape(len(space.points), -1)
        field[:, soft] += (to @ at_vertices).reshape(len(soft), width, count).transpose(2, 0, 1)
    pressure = share[frames, None] * fields.pressure
    return replace(fields, displacement=moved, strain=strain, pressure=pressure)


def _with_modes(answer: Response, history: ModalHistory, grid: TimeGrid) -> Response:
    """Add to an answer which modes had inertia, and whether contact was lost on the way."""
    oscillators = history.body.oscillators
    count = len(oscillators.omega_squared)
    highest = float(oscillators.glassy.max(initial=0.0) / (2 * np.pi))
    notes = (
        *answer.notes,
        f"Inertia: {count} modes up to {highest:.3g} Hz (in sudden strain) in steps of "
        f"{1e3 * grid.longest:.3g} ms; what they leave out deforms as in statics.",
        *_lossless(oscillators),
        *_lost(answer),
    )
    numbers = answer.numbers | {"modes": count, "highest_mode_hz": highest}
    return replace(answer, notes=notes, numbers=numbers)


def _lossless(oscillators: Oscillators) -> Iterator[str]:
    """Yield the note that tissue hardly damps vibrations, if its relaxation ends early."""
    fastest = float(oscillators.rates.max(initial=0.0)) / (2 * np.pi)
    # Frequency in Hz of the fastest relaxation, below which a result notes that vibrations hardly
    # damp.
    damped = 300.0
    if fastest <= damped:
        yield (
            f"The fastest relaxation of this tissue lies at {fastest:.3g} Hz: above it hardly "
            "anything is lost, where fingertips lose most, and resonances are too sharp. The sets "
            "of finger.tissue that end in '_viscous' have a faster branch, of low confidence: it "
            "was identified from vibrations along the skin (Wiertlewski and Hayward 2012)."
        )


def _lost(answer: Response) -> Iterator[str]:
    """Yield a note on a contact that opens while the indenter is below first touch."""
    closed = np.trim_zeros(answer.force > 0)
    times = int(np.count_nonzero(closed[:-1] & ~closed[1:]))
    if times:
        plural = "s" if times > 1 else ""
        yield f"Contact is lost {times} time{plural} before its end, and taken up again."
