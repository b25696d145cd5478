"""Hertz contact of a viscoelastic half-space: a scene in milliseconds.

`theory/contact/hertz.py` has the formula, with which `validation/fem/hertz.py` compares the finite
elements. `theory/contact/ting.py` extends it to unloading, loss of contact and renewed contact.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.stated_errors import stated
from fefinger.mechanics.press import axisymmetric, notes
from fefinger.mechanics.press.mesh_limits import through
from fefinger.mechanics.press.notes import Reason, refusals
from fefinger.mechanics.press.time_steps import time_grid, too_long
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate, Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.progress import Progress
from fefinger.support.text import format_excess
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.relaxation import Prony, creep_integral, in_series


name = "hertz"
traits = Traits(meshed=False, finite=False)

THIN = 0.1
"""Contact radius over the thickness of the tissue, beyond which the bone matters."""

SHAPES = "the contact is that of a plate, sphere or ellipsoid"

STIFFENING = 1.127
"""First coefficient of the force on an incompressible layer bonded to a rigid base, against a
half-space: P / P_Hertz = 1 + 1.127 chi + ..., with chi = sqrt(R depth) / thickness."""

CONTRAST = 1.1
"""Skin modulus over subcutaneous modulus, beyond which a homogeneous body is no answer."""

STEEP = 0.4
"""Contact radius over the radius of the object: there the force on a sphere is 2 % below that on
the paraboloid of Hertz."""

NOTES = (
    "The finger is a homogeneous half-space: no bone, no skin, no nail; a real finger is stiffer.",
    notes.SPHERICAL,
    "Hertz: small strain, a contact small against the radii, no friction.",
    notes.CONVOLVED,
    notes.QUASISTATIC,
)

ELLIPTIC = (
    "The elliptic contact is a circular one of the equivalent radius: within 3.4 % of its depth "
    "and 7 % of its peak pressure for relative radii up to 5 to 1."
)


@dataclass(frozen=True)
class HalfSpace:
    """The relaxed finger under an object: relative radius R mm, modulus E kPa, poisson.

    yielding 1/kPa: (1 - nu²) / E of the relaxed object, 0 of a rigid one; 1 / E* is the sum of both
    bodies' (Pawluk 1997, Eq. 3.21).
    """

    relative_radius: float
    modulus: float
    poisson: float
    yielding: float = 0.0

    @property
    def _slope(self) -> float:
        plane = self.modulus / (1 - self.poisson**2)
        plane = plane / (1 + self.yielding * plane)
        return 4 / 3 * plane * float(np.sqrt(self.relative_radius))

    def share(self, tissue: Prony, own: Prony) -> float:
        """Return the object's part in the compliance at once, by G of the tissue and its own."""
        skin = tissue.long_time * (1 - self.poisson**2) / self.modulus
        yielding = own.long_time * self.yielding
        return yielding / (yielding + skin)

    def force(self, depth: Array) -> Array:
        """Return the force (n,) in mN."""
        return self._slope * depth**1.5

    def depth(self, force: float) -> Array:
        """Return the depth in mm under a force in mN, one number each."""
        return np.asarray((force / self._slope) ** (2 / 3))

    def contact_radius(self, depth: Array) -> Array:
        """Return the contact radius (n,) in mm."""
        return np.sqrt(self.relative_radius * depth)

    def load(self, depth: Array, r: Array) -> Array:
        """Return the force (n, m) in mN within the distances r (m,) mm of the axis."""
        square = np.maximum(self.relative_radius * depth, 1e-300)[:, None]
        outside = np.maximum(1 - r**2 / square, 0.0) ** 1.5
        return self.force(depth)[:, None] * (1 - outside)

    def strain(self, depth: Array, r: Array, z: Array) -> Array:
        """Return e_r, e_t, e_z, e_rz (n, 4, m) of Huber's field at r, z (m,) mm, z > 0.

        It is the one under a rigid object of the same contact radius.
        """
        from fefinger.theory.contact.hertz import Hertz

        strain = np.zeros((len(depth), 4, len(r)))
        for row, reached in zip(strain, depth, strict=True):
            # Deeper nodes belong to creep beyond the time that the force was held.
            if 0 < reached <= self.relative_radius:
                field = Hertz(self.relative_radius, float(reached), self.modulus, self.poisson)
                row[:] = field.strain(r, z)
        return strain


def tissue(finger: Finger) -> tuple[float, float]:
    """Return modulus in kPa and Poisson's ratio of the uniform tissue that replaces skin and pulp.

    Under a contact wider than the skin is thick, the layers bear the same pressure one after the
    other, so the compliances average, weighted by thickness; and so do Poisson's ratios.
    """
    skin, rest = finger.skin, finger.subcutaneous
    part = (skin.thickness or 0.0) / finger.pulp
    modulus = 1 / (part / skin.modulus + (1 - part) / rest.modulus)
    return modulus, part * skin.poisson + (1 - part) * rest.poisson


def half_space(finger: Finger, indenter: Indenter) -> HalfSpace:
    """Return the half-space that replaces the finger under an object."""
    from fefinger.theory.contact.hertz import equivalent_radius, relative_radius

    radii = indenter.hertzian or (indenter.least_radius,) * 2
    first, second = (relative_radius(finger.pad_radius, radius) for radius in radii)
    soft = indenter.soft_body
    yielding = 0.0
    if soft is not None:
        modulus, poisson = soft.surface
        yielding = (1 - poisson**2) / modulus
    return HalfSpace(equivalent_radius(first, second), *tissue(finger), yielding)


def elliptic(indenter: Indenter) -> bool:
    """Return whether the object has two different radii, so that its contact is an ellipse."""
    return indenter.hertzian is not None and indenter.flat is indenter.ball_radius is None


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against Hertz contact for a scene."""
    unable = [*lacking(case), *_layer(case.indenter)]
    if case.indenter.hertzian is None:
        return refusals(name, "ability", unable)
    depth, radius = case.motion.deepest, half_space(case.finger, case.indenter).relative_radius
    if depth is not None and depth > radius:
        reason = f"depth / relative radius = {format_excess(depth / radius, 1)}: Hertz ends there"
        unable.append(Reason("motion.depth", reason))
    if not unable:
        unable += too_deep(case, deepest(case))
    error = math.nan if unable else stated(Candidate(name), case).error
    reasons = [*_reasons_of_size(case), *reasons_of_place(case)]
    if error <= case.ask.rel_error:
        reasons = []
    elif math.isfinite(error):  # they explain the measured error, and go where it is allowed
        reasons = [Reason("ask.rel_error", each.text) for each in reasons]
    return refusals(name, "ability", unable) + refusals(name, "accuracy", reasons)


def _layer(indenter: Indenter) -> Iterator[Reason]:
    """Yield the thickness of a soft object that is no half-space."""
    soft = indenter.soft_body
    if soft is not None and soft.thickness < math.inf:
        reason = f"indenter.thickness = {soft.thickness:g} mm: both bodies are half-spaces here"
        yield Reason("indenter.thickness", reason)


def lacking(case: Situation) -> list[Reason]:
    """Return the features of a scene that a contact of spheres cannot represent."""
    unable = [*notes.own_relaxation_reasons(case.finger), *case.too_long]
    unable += notes.tangential_reasons(case.motion, case.indenter)
    if case.ask.fields:
        reason = "ask.fields: this mechanics has no mesh; ask.fields = false leaves them out"
        unable.append(Reason("ask.fields", reason))
    if case.indenter.hertzian is None:
        unable.append(Reason("indenter", f"indenter.kind = {case.indenter.kind!r}: {SHAPES}"))
    elif axisymmetric.touch(case.finger, case.indenter) is None:
        reason = "indenter.at: it lies beyond the sphere that replaces the pad"
        unable.append(Reason("indenter.at", reason))
    return unable


def too_deep(case: Situation, deepest: float) -> list[Reason]:
    """Return the reason against a force that presses `deepest` mm, if it is through the tissue."""
    reason = through(case.motion, case.finger.pulp, deepest)
    return [Reason("motion.force", reason)] if reason else []


def cost(case: Situation) -> float:
    """Return the expected CPU time in s."""
    return costs.formula_seconds(name, case)


def once(case: Situation) -> float:
    """Return 0: nothing is built and cached."""
    return 0.0


def error(case: Situation, quantity: str = "force") -> tuple[float, str]:
    """Return the expected relative error, and where it comes from.

    Measured, where there is evidence. Else the bone makes the force 1 + 1.127 chi times the one of
    Hertz, and more where chi is not small; the skin leaves the modulus open between those of the
    two tissues.
    """
    measured = stated(Candidate(name), case, quantity)
    if quantity != "force" or math.isfinite(measured.error):
        return measured
    stiffer = STIFFENING * _thinness(case)
    modulus, _ = tissue(case.finger)
    ends = (case.finger.skin.modulus, case.finger.subcutaneous.modulus)
    spread = max(abs(1 - modulus / end) for end in ends)
    source = "first order of the exact bonded layer, and the range of the tissue moduli"
    return stiffer / (1 + stiffer) + spread, source


def coarser(scene: Scene) -> None:
    """Return None: there is no mesh that the answer could depend on."""


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Solve the scene with the fields of Hertz and Huber."""
    body = half_space(scene.finger, scene.indenter)
    plate = HalfSpace(scene.finger.pad_radius, body.modulus, body.poisson)
    used = (
        f"The half-space has {body.modulus:.4g} kPa and Poisson's ratio {body.poisson:.4g}: "
        "the compliances of skin and pulp averaged by thickness."
    )
    ellipse = (ELLIPTIC,) if elliptic(scene.indenter) else ()
    object_ = notes.object_note(scene.indenter)
    stated = (*NOTES, used, object_, *notes.normalization_notes(scene.finger.prony), *ellipse)
    numbers = {
        "relative_radius_mm": body.relative_radius,
        "modulus_kPa": body.modulus,
        "poisson": body.poisson,
        "contact_radius_over_thickness": _thinness(Situation.of(scene)),
    }
    return axisymmetric.respond(
        *(scene, body, plate, progress),
        mechanics=name,
        notes=stated,
        numbers=numbers,
        share=body.share(scene.finger.prony, scene.indenter.soft_prony),
    )


def deepest(case: Situation) -> float:
    """Return the largest depth in mm."""
    if case.motion.deepest is not None:
        return case.motion.deepest
    body = half_space(case.finger, case.indenter)
    tissue, own = case.finger.prony, case.indenter.soft_prony
    both = in_series(tissue, body.share(tissue, own), own)
    return float(body.depth(elastic_peak(case.motion, both)))


@lru_cache(maxsize=32)
def elastic_peak(motion: Motion, prony: Prony) -> float:
    """Return the largest elastic force in mN under a motion that prescribes the force.

    That is the force on relaxed tissue at the same contact, as long as the contact grows; of a
    motion that is too long to answer the largest force itself.
    """
    if too_long(motion, fast=False):
        return motion.peak / NEWTON_PER_MILLINEWTON
    time = time_grid(motion, fast=False)
    load = motion.value(time) / NEWTON_PER_MILLINEWTON
    return float(creep_integral(prony, time, load).max()) * prony.long_time


def widest(case: Situation) -> float:
    """Return the largest contact radius in mm."""
    return float(half_space(case.finger, case.indenter).contact_radius(np.array(deepest(case))))


def _thinness(case: Situation) -> float:
    return widest(case) / case.finger.pulp


def _reasons_of_size(case: Situation) -> Iterator[Reason]:
    thin = _thinness(case)
    if thin > THIN:
        reason = (
            f"contact radius / tissue thickness = {format_excess(thin, THIN)}: with the bone below "
            f"it takes more than {1 + STIFFENING * thin:.2g} times the force"
        )
        yield Reason("motion", reason)
    contrast = case.finger.skin.modulus / case.finger.subcutaneous.modulus
    if max(contrast, 1 / contrast) > CONTRAST:
        reason = (
            f"skin modulus / subcutaneous modulus = {contrast:.2g}, not within {CONTRAST:g}: the "
            "half-space has one modulus"
        )
        yield Reason("finger.skin.modulus", reason)
    steep = widest(case) / case.indenter.least_radius
    if steep > STEEP:
        reason = f"contact radius / radius of the object = {format_excess(steep, STEEP)}: it is no "
        yield Reason("motion", f"{reason}paraboloid")


def reasons_of_place(case: Situation) -> Iterator[Reason]:
    """Yield the reasons why one pad radius is not valid where the pad is touched."""
    if case.finger.surface is not None:
        radius = f"{case.finger.pad_radius:g} mm"
        reason = f"finger.surface: the scan is left out; a pad of pad_radius = {radius} replaces it"
        yield Reason("finger.surface", reason)
    flat = case.indenter.flat
    if flat is not None:
        # Degrees from the standard plate within which what is known of it is taken to hold, a
        # convention: at .5 mm the force on the finger of a.h. (`linear`) falls by 8 % to 35
        # degrees, by 25 % to 40.
        aside = 2.5
        if abs(flat.angle - STANDARD.angle) > aside:
            reason = (
                f"angle = {flat.angle:g} degrees is not within {aside:g} of "
                f"{STANDARD.angle:g}: Hertz contact does not depend on the angle"
            )
            yield Reason("indenter.angle", reason)
        if flat.tilt:
            reason = f"tilt = {flat.tilt:g} > 0 degrees: R is that of the middle"
            yield Reason("indenter.tilt", reason)
        return
    away = math.hypot(*(case.indenter.place or (0.0, 0.0)))
    # Distance in mm from the first touch of the 30 degree plate within which the radius holds.
    near = 2.0
    if away > near:
        reason = f"distance of indenter.at from the middle = {format_excess(away, near)} mm"
        yield Reason("indenter.at", f"{reason}: R is that of the middle")
