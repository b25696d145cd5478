"""Causes of differences in R, m and c0 b of the thesis's fit of the frames of a slow press.

One change at a time: in the finger (its modulus and exponent are fitted to the force again), in the
array and its reading, and in the force that the fit has to share with Table 2.1.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np
from fefinger.validation.calibration.subject_target import printed, target_of
from fefinger.validation.oracles.fingerpad import Fingerpad

from fefinger.calibration import pad_radius as pad
from fefinger.calibration import targets
from fefinger.calibration.array_sensor import ArraySensor, Frames, aligned, blurred
from fefinger.calibration.curve import family
from fefinger.calibration.inverse import solve
from fefinger.calibration.outcome import FitResult, layer, line, stiffening
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.search import SMALLER
from fefinger.calibration.slow_press import SlowPress, press
from fefinger.calibration.targets import Forces
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Hard
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.theory.relaxation import Prony


FORCE = 1.1
"""N to which all fingers are pressed for the comparison, the middle one of Figure 3-4."""

EXPONENTS = (1.5, 3.0, 4.5)
"""Exponents at which a finger is pressed, and joined by a parabola."""

SOLVED = 0.16
"""Depth over the thickness at which a press that ends early still counts."""

LOW = 0.02
"""Exponent of a layer that is not to stiffen."""

EARLY = 0.3
"""mm by which a finger is touched before the line of Table 2.1 has no force, about."""

NOISES = 5

Laws = Callable[[Finger, float], Finger]


@dataclass(frozen=True)
class Found:
    """What the thesis's fit finds: R mm, m 1/mm, c0 b kPa/mm and its squared error, a fraction."""

    lever: str
    radius: float
    m: float
    c0_b: float
    error: float


@dataclass(frozen=True)
class Fitted(Found):
    """The same of a finger, with what was fitted to the force.

    modulus kPa and exponent; stiffness_m 1/mm and stiffness_b N/mm of the line through stiffness
    against force; misfit; depth mm and width mm, root mean square, of the pressure at `force` N.
    """

    modulus: float
    exponent: float
    stiffness_m: float
    stiffness_b: float
    misfit: float
    force: float
    depth: float
    width: float


def fingers(start: Finger) -> Iterator[tuple[str, Finger, Laws]]:
    """Yield name, finger and law at an exponent: one thing after the other is changed."""
    skin, pulp = start.skin, start.subcutaneous
    yield "the finger as it is", start, stiffening
    smaller = replace(start, pad_radius=SMALLER * start.pad_radius)
    yield f"pad radius x {SMALLER:g}", smaller, stiffening
    for ratio in (1.0, 3.0):
        stiff = replace(start, skin=replace(skin, modulus=ratio * pulp.modulus))
        yield f"skin {ratio:g} times as stiff as pulp ({library.SKIN_RATIO:g})", stiff, stiffening
    thin = replace(start, skin=replace(skin, thickness=0.5))
    yield "skin 0.5 mm thick (1)", thin, stiffening
    for poisson in (0.4, 0.499):
        one, other = (replace(each, poisson=poisson) for each in (skin, pulp))
        loose = replace(start, skin=one, subcutaneous=other)
        yield f"Poisson's ratio {poisson:g} (0.48)", loose, stiffening
    yield "nail free (held)", replace(start, nail="free"), stiffening
    for ahead in (3.8, 5.0):
        longer = replace(start, tip_tissue=ahead)
        yield f"bone ends {ahead:g} mm before the tip ({start.tip_tissue:g})", longer, stiffening
    sharper = replace(start, tip_radius=2.0)
    yield f"tip of radius 2 mm ({start.tip_radius:g})", sharper, stiffening
    yield "bone elastic, 17 GPa (rigid)", replace(start, bone=Hard(17e6)), stiffening
    yield "proximal cut held by bone and nail alone", replace(start, cut="nail"), stiffening
    yield "one exponent in both layers", start, both
    yield "skin alone stiffens", start, lambda one, exponent: layers(one, 2.5 * exponent, LOW)
    yield "pulp alone stiffens", start, lambda one, exponent: layers(one, LOW, exponent)


def both(finger: Finger, exponent: float) -> Finger:
    """Return the finger with the exponent in both layers."""
    return layers(finger, exponent, exponent)


def layers(finger: Finger, skin: float, pulp: float) -> Finger:
    """Return the finger with an exponent in each layer."""
    return replace(
        finger, skin=layer(finger.skin, skin), subcutaneous=layer(finger.subcutaneous, pulp)
    )


def of_finger(name: str, finger: Finger, law: Laws) -> Fitted | None:
    """Apply the thesis's fit to a finger whose tissue has the force of its subject.

    Without a prior on the modulus. None where fewer than two of its presses are solved.
    """
    assert finger.subject_name is not None
    done = fit(finger, law)
    if done is None:
        return None
    solution, wanted = done.solution, target_of(finger.subject_name)
    frames = pad.simulated(done.law, heaviest=FORCE)
    thesis_fit, last = pad.thesis_fit(frames), frames.pressure[-1]
    m, b = line(wanted.force, done.law.stiffness(wanted.force))
    return Fitted(
        name,
        *(thesis_fit.radius, thesis_fit.m, thesis_fit.c0_b, thesis_fit.error),
        solution.values["modulus"],
        solution.values["exponent"],
        *(m, b, solution.misfit),
        float(4e-3 * last.sum()),
        float(frames.depth.max()),
        float(np.sqrt(last @ frames.distance**2 / last.sum())),
    )


def fit(finger: Finger, law: Laws, exponents: tuple[float, ...] = EXPONENTS) -> FitResult | None:
    """Fit modulus, exponent and relaxation of a finger to its subject, without a prior of E.

    None where fewer than two of its presses are solved.
    """
    assert finger.subject_name is not None
    presses = dict(_pressed(finger, law, exponents))
    if len(presses) < 2:
        return None
    curves = family(tuple(presses), finger.pad_radius, presses.__getitem__)
    wanted, modulus = target_of(finger.subject_name), finger.subcutaneous.modulus
    forces = Forces(wanted, curves, modulus, 1.0, finger.pad_radius)
    free = [replace(each, prior=None) for each in forces.unknowns if not each.held]
    solution = solve(forces.residual, free, forces.starts())
    return FitResult(solution, forces.law(solution.values), wanted)


def _pressed(
    finger: Finger, law: Laws, exponents: tuple[float, ...]
) -> Iterator[tuple[float, SlowPress]]:
    """Yield exponents and presses that are solved to SOLVED at least."""
    for exponent in exponents:
        try:
            pressed = press(law(finger, exponent), "solid")
        except ConvergenceError:
            continue
        if pressed.depth[-1] > SOLVED * finger.thickness:
            yield exponent, pressed


def of_fingers(subject: str) -> list[dict[str, float | str]]:
    """Return the changes of the finger of a subject, on the coarse mesh."""
    start = Work(targets.finger_of(subject, resolution="coarse"), None).finger
    tried = (of_finger(*each) for each in fingers(start))
    return [asdict(each) for each in tried if each is not None]


def of_reading(calibration: Calibration) -> list[Found]:
    """Return the changes of the array and of how it is read, for a calibrated finger."""
    sensor, law = ArraySensor(), calibration.law
    plain = pad.simulated(law)
    inner = plain.distance < 6.0
    near = Frames(plain.depth[:, inner], plain.pressure[:, inner], plain.distance[inner])
    clipped = np.where(plain.pressure < sensor.noise, 0.0, plain.pressure)
    about = np.hypot(*sensor.positions.T)
    made = {
        "frames as they are": plain,
        "pressed to 0.54 N": pad.simulated(law, heaviest=0.54),
        "pressed to 1.1 N": pad.simulated(law, heaviest=1.1),
        "tissue that does not relax": pad.simulated(replace(law, prony=Prony((1.0,), ()))),
        "noise of 0.5 kPa": pad.simulated(law, seed=0),
        "readings below 0.5 kPa dropped": replace(plain, pressure=clipped),
        "elements within 6 mm": near,
        "about the middle of the array": replace(plain, distance=about),
        "touch found 0.15 mm late": replace(plain, depth=plain.depth - 0.15),
        "touch found 0.15 mm early": replace(plain, depth=plain.depth + 0.15),
    }
    return [_fit(name, frames) for name, frames in made.items()]


def of_force(calibration: Calibration) -> list[Found]:
    """Apply the thesis's fit to contacts of Hertz's shape and the printed R, by their force."""
    subject, law = calibration.target, calibration.law
    radius, row = printed(subject).radius, library.lumped()[subject]
    depth = pad.slow_press(law)
    relaxed = row.prony.long_time * row.b / row.m
    top = float(np.log1p(pad.HEAVIEST / relaxed) / row.m)
    made = {
        "force of the calibrated finger": (depth, pad.slow(law.prony, depth, law.relaxed(depth)))
    }
    for early in (0.0, EARLY):
        deep = np.linspace(0.0, top + early, len(depth))
        force = relaxed * np.expm1(row.m * np.maximum(deep - early, 0.0))
        note = f", touched {early:g} mm before its zero" if early else ""
        made[f"relaxed force of Table 2.1{note}"] = deep, force
    fits = [_fit(name, hertzian(radius, *each)) for name, each in made.items()]
    return [*fits, _fit("Table 3.2 itself, with noise", half_space(subject, 0))]


def _fit(name: str, frames: Frames) -> Found:
    fit = pad.thesis_fit(frames)
    return Found(name, fit.radius, fit.m, fit.c0_b, fit.error)


def hertzian(radius: float, depth: Array, force: Array) -> Frames:
    """Return frames of a contact of Hertz's shape at depths mm and forces N (n,) of any law."""
    chosen = np.linspace(0, len(depth) - 1, pad.LEVELS + 1).astype(int)[1:]
    x, newtons = depth[chosen, None], force[chosen, None]

    def pressure(r: Array) -> Array:
        square = radius * x
        return 1.5e3 * newtons / (np.pi * square) * np.sqrt(np.maximum(1 - r**2 / square, 0.0))

    return _framed(depth[chosen], radius, pressure)


def half_space(subject: str, seed: int | None = None) -> Frames:
    """Return frames of the half-space of Table 3.2 to 2.3 N; `seed` starts the noise, if any."""
    row = library.quasistatic()[subject]
    one = Fingerpad(row.radius, row.m, row.b, library.relaxation()[subject])
    deepest = float(one.depth_at(1e3 * pad.HEAVIEST, relaxed=True))
    depth = np.linspace(0.0, deepest, pad.LEVELS + 1)[1:]
    frames = _framed(depth, row.radius, lambda r: one.relaxed_pressure(r, depth[:, None]))
    if seed is None:
        return frames
    noise = np.random.default_rng(seed).normal(0.0, ArraySensor().noise, frames.pressure.shape)
    return replace(frames, pressure=frames.pressure + noise)


def _framed(depth: Array, radius: float, pressure: Callable[[Array], Array]) -> Frames:
    """Return frames at depths (n,) mm of round pressures; `pressure` takes (k,), gives (n, k)."""
    distance = np.hypot(*ArraySensor().positions.T)

    def reading(frame: int) -> Array:
        reach = math.sqrt(radius * float(depth[frame]))
        return blurred(lambda r: pressure(r)[frame], reach, distance)

    rows = [reading(frame) for frame in range(len(depth))]
    return aligned(np.repeat(depth[:, None], len(distance), axis=1), np.array(rows), ArraySensor())


def oracle(subject: str) -> float:
    """Return the largest relative miss of R, m and c0 b that come back from Table 3.2 itself.

    The mean over NOISES readings with the noise of the array.
    """
    row = printed(subject)
    fits = [pad.thesis_fit(half_space(subject, seed)) for seed in range(NOISES)]
    names = ("radius", "m", "c0_b")
    means = {name: float(np.mean([getattr(fit, name) for fit in fits])) for name in names}
    return max(abs(means[name] / getattr(row, name) - 1) for name in names)
