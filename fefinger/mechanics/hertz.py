"""Hertz contact of a relaxing half-space, as an answer to a scene: milliseconds.

`theory/hertz.py` is the formula, `validation/fem/hertz.py` the proof of the elements.
`theory/ting.py` makes it right on unloading, loss of contact and touching again.
"""

from dataclasses import dataclass

import numpy as np

from fefinger.mechanics.evidence import tradeoff
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.press import axisymmetric
from fefinger.mechanics.press.axisymmetric import Array
from fefinger.mechanics.press.notes import apart, normalized, yielding
from fefinger.mechanics.press.time_steps import time_grid, too_long
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress
from fefinger.support.text import beyond
from fefinger.support.units import NEWTON_PER_MILLINEWTON


name = "hertz"

THIN = 0.1
"""Contact radius over the thickness of the tissue, beyond which the bone is felt."""

SHAPES = "the contact is that of a plate, sphere or ellipsoid"

STIFFENING = 1.127
"""First coefficient of the force on an incompressible layer bonded to a rigid base, against a
half-space: P / P_Hertz = 1 + 1.127 chi + ..., with chi = sqrt(R depth) / thickness."""

CONTRAST = 1.1
"""Skin modulus over subcutaneous modulus, beyond which a homogeneous body is no answer."""

STEEP = 0.4
"""Contact radius over the radius of the object: there the force on a sphere is 2 % below that on
the paraboloid of Hertz."""

ASIDE = 2.5
"""Degrees from the standard plate within which what is known of it is taken to hold, a convention:
at .5 mm the force on the finger of a.h. (`linear`) falls by 8 % to 35 degrees, by 25 % to 40."""

NEAR = 2.0
"""Distance in mm from the first touch of the 30 degree plate within which the radius holds."""

NOTES = (
    "The finger is a homogeneous half-space: no bone, no skin, no nail; a real finger is stiffer.",
    "The pad is a sphere of one effective radius; its pressure is symmetric about the first touch.",
    "Hertz: small strain, a contact small against the radii, no friction, a rigid object.",
    "The whole stress relaxes with one function G(t); strain is the elastic field of the pressure "
    "convolved with the creep function.",
    "Quasi-static: no inertia and no waves.",
)


ELLIPTIC = (
    "The elliptic contact is a circular one of the equivalent radius: within 3.4 % of its depth "
    "and 7 % of its peak pressure for relative radii up to 5 to 1."
)


@dataclass(frozen=True)
class HalfSpace:
    """The relaxed finger under an object: relative radius R mm, modulus E kPa, poisson."""

    relative_radius: float
    modulus: float
    poisson: float

    @property
    def _slope(self) -> float:
        """Force over depth^(3/2)."""
        plane = self.modulus / (1 - self.poisson**2)
        return 4 / 3 * plane * float(np.sqrt(self.relative_radius))

    def force(self, depth: Array) -> Array:
        """Return the force (n,) in mN."""
        return self._slope * depth**1.5

    def depth(self, force: float) -> float:
        """Return the depth in mm under a force in mN."""
        return float((force / self._slope) ** (2 / 3))

    def radius(self, depth: Array) -> Array:
        """Return the contact radius (n,) in mm."""
        return np.sqrt(self.relative_radius * depth)

    def load(self, depth: Array, r: Array) -> Array:
        """Return the force (n, m) in mN within the distances r (m,) mm of the axis."""
        square = np.maximum(self.relative_radius * depth, 1e-300)[:, None]
        outside = np.maximum(1 - r**2 / square, 0.0) ** 1.5
        return self.force(depth)[:, None] * (1 - outside)

    def strain(self, depth: Array, r: Array, z: Array) -> Array:
        """Return e_r, e_t, e_z, e_rz (n, m, 4) of Huber's field at r, z (m,) mm, z > 0."""
        from fefinger.theory.contact.hertz import Hertz

        strain = np.zeros((len(depth), len(r), 4))
        for row, reached in zip(strain, depth, strict=True):
            # Deeper nodes are those of a force that has crept for longer than it was held.
            if 0 < reached <= self.relative_radius:
                field = Hertz(self.relative_radius, float(reached), self.modulus, self.poisson)
                row[:] = field.strain(r, z).T
        return strain


def tissue(finger: Finger) -> tuple[float, float]:
    """Return modulus in kPa and Poisson's ratio of the one tissue that stands for skin and pulp.

    Under a contact wider than the skin is thick, the layers bear the same pressure one after the
    other, so the compliances average, weighted by thickness; and so do Poisson's ratios.
    """
    skin, rest = finger.skin, finger.subcutaneous
    part = (skin.thickness or 0.0) / finger.pulp
    modulus = 1 / (part / skin.modulus + (1 - part) / rest.modulus)
    return modulus, part * skin.poisson + (1 - part) * rest.poisson


def half_space(scene: Scene) -> HalfSpace:
    """Return the half-space that stands for the finger under the object of the scene."""
    from fefinger.theory.contact.curvature import equivalent_radius, relative_radius

    pad, indenter = scene.finger.pad_radius, scene.indenter
    radii = indenter.hertzian or (indenter.least_radius,) * 2
    first, second = (relative_radius(pad, radius) for radius in radii)
    return HalfSpace(equivalent_radius(first, second), *tissue(scene.finger))


def elliptic(scene: Scene) -> bool:
    """Return whether the object has two radii of its own, so that its contact is an ellipse."""
    indenter = scene.indenter
    return indenter.hertzian is not None and indenter.flat is indenter.ball_radius is None


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer."""
    unable = lacking(scene)
    if scene.indenter.hertzian is None:
        return tuple(Refusal(name, "ability", reason) for reason in unable)
    depth, radius = scene.motion.peak, half_space(scene).relative_radius
    if scene.motion.control == "depth" and depth > radius:
        unable.append(f"depth / relative radius = {beyond(depth / radius, 1)}: Hertz ends there")
    measured = not unable and tradeoff.stated(name, scene) is not None
    doubts = [] if measured else [*_doubts_of_size(scene), *doubts_of_place(scene)]
    return (
        *(Refusal(name, "ability", reason) for reason in unable),
        *(Refusal(name, "accuracy", reason) for reason in doubts),
    )


def lacking(scene: Scene) -> list[str]:
    """Return what of a scene no contact of one sphere with one flat body has a place for."""
    unable = [*yielding(scene.finger), *apart(scene.finger)]
    unable += too_long(scene.motion, fast="FAII" in scene.ask.spikes)
    if scene.ask.fields:
        unable.append("ask.fields: it has no mesh; ask.fields = false leaves them out")
    if scene.indenter.hertzian is None:
        unable.append(f"indenter.kind = {scene.indenter.kind!r}: {SHAPES}")
    elif axisymmetric.touch(scene) is None:
        unable.append("indenter.at: it lies beyond the sphere that stands for the pad")
    return unable


def cost(scene: Scene) -> float:
    """Return the expected wall time in s, from a count of operations."""
    steps = len(time_grid(scene.motion, fast="FAII" in scene.ask.spikes))
    return (0.05 + 5e-5 * steps) * slowness({})


def error(scene: Scene) -> tuple[float, str]:
    """Return the expected relative error of the force, and where it comes from.

    That is the measured one. Where none is, the bone makes the force 1 + 1.127 chi times that of
    Hertz, and more where chi is not small; the skin leaves the modulus open between those of the
    two tissues.
    """
    found = tradeoff.stated(name, scene)
    if found is not None:
        return found.error, found.source
    stiffer = STIFFENING * _thinness(scene)
    modulus, _ = tissue(scene.finger)
    ends = (scene.finger.skin.modulus, scene.finger.subcutaneous.modulus)
    spread = max(abs(1 - modulus / end) for end in ends)
    source = "first order of the exact bonded layer, and the range of the tissue moduli"
    return stiffer / (1 + stiffer) + spread, source


def coarser(scene: Scene) -> None:
    """Return None: there is no mesh that the answer could depend on."""


def respond(scene: Scene, progress: Progress | None = None) -> Response:
    """Answer the scene with the fields of Hertz and Huber.

    Raises
    ------
    InputError
        If the indenter is placed beyond the pad.
    """
    body = half_space(scene)
    plate = HalfSpace(scene.finger.pad_radius, body.modulus, body.poisson)
    used = (
        f"The half-space has {body.modulus:.4g} kPa and Poisson's ratio {body.poisson:.4g}: "
        "the compliances of skin and pulp averaged by thickness."
    )
    notes = (*NOTES, used, *normalized(scene.finger.prony))
    if elliptic(scene):
        notes = (*notes, ELLIPTIC)
    numbers = {
        "relative_radius_mm": body.relative_radius,
        "modulus_kPa": body.modulus,
        "poisson": body.poisson,
        "contact_radius_over_thickness": _thinness(scene),
    }
    return axisymmetric.respond(
        scene, body, plate, progress, mechanics=name, notes=notes, numbers=numbers
    )


def deepest(scene: Scene) -> float:
    """Return the largest depth in mm, of a motion under force control when it has crept."""
    if scene.motion.control == "depth":
        return scene.motion.peak
    return half_space(scene).depth(scene.motion.peak / NEWTON_PER_MILLINEWTON)


def widest(scene: Scene) -> float:
    """Return the largest contact radius in mm."""
    return float(half_space(scene).radius(np.array(deepest(scene))))


def _thinness(scene: Scene) -> float:
    return widest(scene) / scene.finger.pulp


def _doubts_of_size(scene: Scene) -> list[str]:
    doubts = []
    thin = _thinness(scene)
    if thin > THIN:
        reason = f"contact radius / tissue thickness = {beyond(thin, THIN)}: with the bone below "
        doubts.append(f"{reason}it takes more than {1 + STIFFENING * thin:.2g} times the force")
    contrast = scene.finger.skin.modulus / scene.finger.subcutaneous.modulus
    if max(contrast, 1 / contrast) > CONTRAST:
        reason = f"skin modulus / subcutaneous modulus = {contrast:.2g}"
        doubts.append(f"{reason}, not within {CONTRAST:g}: the half-space has one modulus")
    steep = widest(scene) / scene.indenter.least_radius
    if steep > STEEP:
        doubts.append(
            f"contact radius / radius of the object = {beyond(steep, STEEP)}: it is no paraboloid"
        )
    return doubts


def doubts_of_place(scene: Scene) -> list[str]:
    """Return why one radius in the middle of the pad does not stand for what is touched."""
    doubts = []
    if scene.finger.surface is not None:
        radius = f"{scene.finger.pad_radius:g} mm"
        doubts.append(f"finger.surface: the scan is left out; pad_radius = {radius} stands for it")
    flat = scene.indenter.flat
    if flat is not None:
        if abs(flat.angle - STANDARD.angle) > ASIDE:
            reason = f"angle = {flat.angle:g} degrees is not within {ASIDE:g} of "
            doubts.append(f"{reason}{STANDARD.angle:g}: to it the pad is alike at all angles")
        if flat.tilt:
            doubts.append(f"tilt = {flat.tilt:g} > 0 degrees: R is that of the middle")
        return doubts
    away = float(np.hypot(*(scene.indenter.place or (0.0, 0.0))))
    if away > NEAR:
        reason = f"distance of indenter.at from the middle = {beyond(away, NEAR)} mm"
        doubts.append(f"{reason}: R is that of the middle")
    return doubts
