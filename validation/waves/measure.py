"""Measures what inertia changes, what modes leave out, and what both cost: `reports/modal.json`.

    python -m fefinger.validation.waves.measure reports/modal.json

The planner reads it (`mechanics/evidence/vibration.py`). Statics are compared with inertia in one
linear finger: in frequency as the change of the dynamic stiffness under an indenter, in time as the
largest change of the force of a ramp over its peak. Errors of vibrations are over the stiffness
without inertia at that frequency, with the published relaxation, whose resonances hardly damp, and
with one that goes on to a kHz. Tissue that stiffens is compared with `solid`, linearized about the
compressed finger (`preload.py`).
"""

import json
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save
from fefinger.validation.waves.preload import Preloaded, modulus, viscous

from fefinger.contact.stepper import Target
from fefinger.mechanics.evidence.vibration import suddenness
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.loop_setup import SUBSTEP
from fefinger.mechanics.press.modal_body import FingerModes, ModalBody, finger_modes
from fefinger.mechanics.press.modal_press import contact_of
from fefinger.mechanics.press.operator import operator
from fefinger.mechanics.vibrations import Vibrations
from fefinger.scene.cautions import wave_speed
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold
from fefinger.support.arrays import Array


SUBJECTS = ("d.p.", "d.s.", "a.h.", "p.w.")
TISSUE = "maeno1998"
RELAXATIONS = {"published": TISSUE, "viscous": f"{TISSUE}_viscous"}
OBJECTS: dict[str, Indenter] = {"flat-30": Flat(30), "sphere-5": Sphere(5)}
PARTS = 0.05, 0.1, 0.15
"""Preloads over the thickness of the finger."""

REDUCED = np.geomspace(0.005, 1.0, 60)
"""Frequency x thickness of the tissue / wave speed, with the modulus at that frequency."""

PRELOADED = 0.05, 0.1, 0.13
"""Preloads over the thickness of stiffening fingers; vibrations about the first two."""

FEW_REDUCED = np.array([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 0.9])
"""Of vibrations about a preload at finite strain, each of which takes seconds."""

RATIOS = np.linspace(0.02, 0.7, 69)
"""Frequencies over that of the last mode."""

SPEEDS = 20.0, 60.0, 200.0, 500.0, 1000.0, 2000.0
"""Speeds of ramps in mm/s to a tenth of the thickness."""

SUDDEN = 20.0, 60.0, 150.0, 300.0, 600.0
"""Speeds in mm/s of presses to a tenth of the thickness, with corners and without."""

PARTS_OF_MODES = 0.25, 0.5
"""Share of the modes that swing in such presses, against all of them."""


def frequencies(finger: Finger, reduced: Array, stiffer: float = 1.0) -> Array:
    """Frequencies (n,) in Hz at which frequency x thickness / wave speed has given values.

    stiffer: factor on the moduli.
    """
    tried = np.geomspace(0.1, 5000, 4000)
    speeds = wave_speed(finger) * np.sqrt(stiffer * np.abs(modulus(finger, tried)))
    return np.asarray(np.interp(reduced, tried * finger.pulp / speeds, tried))


def vibrations(relaxation: str, finger: Finger) -> Iterator[dict[str, Any]]:
    """Yield the change of the dynamic stiffness by inertia, per object and preload."""
    frequency = frequencies(finger, REDUCED)
    for name, indenter in OBJECTS.items():
        loop = Vibrations(finger, indenter, deepest=max(PARTS) * finger.thickness)
        for part in PARTS:
            answer = loop.harmonic(frequency, depth=part * finger.thickness)
            slow = loop.harmonic([1e-3], depth=part * finger.thickness).stiffness[0]
            still = slow / modulus(finger, np.array([1e-3])) * modulus(finger, frequency)
            yield {
                "relaxation": relaxation,
                "object": name,
                "part": part,
                "error": np.abs(answer.stiffness / still - 1).tolist(),
            }


def ramps(finger: Finger) -> Iterator[dict[str, float]]:
    """Yield the largest change of the force of ramps by inertia, over their peak."""
    depth = 0.1 * finger.thickness
    body = _stepped(finger, 1.1 * depth, SUBSTEP)
    for speed in SPEEDS:
        motion = Ramp(speed, depth)
        dt = min(1e-4, motion.duration / 100)
        moving, still = (pressed_force(body, motion, dt, longest) for longest in (1.001 * dt, 0.0))
        change = np.abs(moving - still).max() / moving.max()
        yield {"speed_over_wave": speed / wave_speed(finger), "error": float(change)}


def presses(relaxation: str, finger: Finger) -> Iterator[dict[str, Any]]:
    """Yield what presses with a part of the modes are off, over the largest force, by suddenness.

    Each is a ramp and a rest in which the finger rings.
    """
    depth, dt = 0.1 * finger.thickness, 2e-5
    whole_body = _stepped(finger, 1.1 * depth, dt)
    count = len(whole_body.oscillators.omega_squared)
    parts = (whole_body.only(np.arange(int(p * count))) for p in PARTS_OF_MODES)
    bodies = [whole_body, *parts]
    for speed, corner in product(SUDDEN, ({}, {"corner": 0.0})):
        motion = RampHold(speed, depth, hold=0.01, **corner)
        whole, *others = (pressed_force(body, motion, dt) for body in bodies)
        for body, force in zip(bodies[1:], others, strict=True):
            cycle = 2 * np.pi / float(np.sqrt(body.oscillators.omega_squared[-1]))
            error = float(np.abs(force - whole).max() / whole.max())
            yield {
                "relaxation": relaxation,
                "suddenness": suddenness(motion, cycle),
                "error": error,
            }


def _stepped(finger: Finger, deepest: float, dt: float) -> ModalBody:
    """Return the body of a finger, of the modes that steps of `dt` s resolve."""
    loop = Loop(finger, Flat(30), mechanics="modal", deepest=deepest, substep=dt)
    assert loop.prepared.body is not None
    return loop.prepared.body


def pressed_force(
    body: ModalBody, motion: Motion, dt: float, longest: float | None = None
) -> Array:
    """Return the force (n_t,) on a body through a motion, in mN on what is meshed.

    Modes swing in steps up to `longest` s, by default in these of `dt` s.
    """
    contact, force = contact_of(body, dt * (1 + 1e-6) if longest is None else longest), []
    for t in np.arange(1, int(motion.duration / dt) + 1) * dt:
        assert contact.advance(dt, Target(float(motion.value(t)))) == 0
        force.append(float(body.static.patch.projected @ contact.pressure))
    return np.array(force)


def between_meshes(relaxation: str, subject: str) -> dict[str, Any]:
    """Return the change of the dynamic stiffness by inertia from the coarse to the standard mesh.

    Both over the stiffness without inertia on the same mesh.
    """
    changes = []
    for mesh in ("coarse", "standard"):
        finger = Finger.subject(subject, tissue=RELAXATIONS[relaxation], resolution=mesh)
        frequency, depth = frequencies(finger, REDUCED), 0.1 * finger.thickness
        answer = Vibrations(finger, Flat(30), deepest=depth).harmonic(
            [1e-3, *frequency], depth=depth
        )
        factors = modulus(finger, answer.frequency)
        changes.append((answer.stiffness / answer.stiffness[0] * factors[0] / factors)[1:])
    difference = np.abs(changes[1] - changes[0])
    return {
        "relaxation": relaxation,
        "error": difference.tolist(),
    }


def preloads() -> Iterator[dict[str, Any]]:
    """Yield what stiffening tissue changes of a vibration about a preload, per preload and subject.

    As `modal` does, the share of the stress of the preload is taken as the mean of the subjects.
    """
    fingers = [Finger.subject(subject, resolution="coarse") for subject in SUBJECTS]
    for part in PRELOADED:
        pressed = [Preloaded.of(finger, part * finger.thickness) for finger in fingers]
        shares = [each.statics[0] / sum(each.statics) - 1 for each in pressed]
        for finger, prepared, share in zip(fingers, pressed, shares, strict=True):
            row: dict[str, Any] = {"part": part, "factor": prepared.factor, "share": share}
            for relaxation in RELAXATIONS if part < PRELOADED[-1] else ():
                other = finger if relaxation == "published" else viscous(finger)
                row[relaxation] = preload_errors(prepared, other, float(np.mean(shares)))
            yield row


def preload_errors(prepared: Preloaded, finger: Finger, share: float) -> dict[str, list[float]]:
    """Errors of the harmonic answer about a preload; its share of statics is that through time.

    share: of the stress of the preload, as `modal` takes it.
    """
    frequency = frequencies(finger, FEW_REDUCED, prepared.factor)
    answer, exact = prepared.linear(finger, frequency, share), prepared.exact(finger, frequency)
    still = np.abs(prepared.still(finger, frequency))
    return {"reduced": FEW_REDUCED.tolist(), "error": (np.abs(answer - exact) / still).tolist()}


def truncation(relaxation: str, finger: Finger) -> Iterator[dict[str, Any]]:
    """Yield what the modes of the time answer leave out, by frequency over the last mode's.

    Over the stiffness without inertia.
    """
    depth = 0.1 * finger.thickness
    loop = Vibrations(finger, Flat(30), deepest=depth)
    vibrating = loop.vibrating
    full, solid = vibrating.body, vibrating.solid
    active = np.flatnonzero(vibrating.preload(depth, None)[1] > 0)
    reduced = RATIOS
    frequency = np.geomspace(1.0, 5000.0, 4000)
    last = np.sqrt(np.abs(modulus(finger, frequency))) * loop.modes.complete
    chosen = np.interp(reduced, frequency / last, frequency)
    reference = loop.harmonic(chosen, depth=depth).stiffness
    slow = loop.harmonic([1e-3], depth=depth).stiffness[0]
    still = np.abs(slow / modulus(finger, np.array([1e-3])) * modulus(finger, chosen))
    weights = full.static.patch.projected[active]
    for ratio, f, wanted, scale in zip(reduced, chosen, reference, still, strict=True):
        g = full.oscillators.modulus(np.array([f]))[0]
        receptance = 1.0 / (full.oscillators.omega_squared * g - (2 * np.pi * f) ** 2)
        part = full.participation[:, active]
        flexibility = (
            full.residual_flexibility[np.ix_(active, active)] / g + (part.T * receptance) @ part
        )
        stiffness = solid.sides * 1e-3 * weights @ np.linalg.solve(flexibility, weights)
        yield {
            "relaxation": relaxation,
            "ratio": float(ratio),
            "error": float(abs(stiffness - wanted) / scale),
        }


def seconds(subject: str, mesh: str) -> dict[str, float]:
    """CPU seconds of the modes of half a finger, of reading them on a pad, and of a step."""
    finger = Finger.subject(subject, tissue=TISSUE, resolution=mesh)
    solid = operator(finger, half=True)
    anonymous = replace(solid, identities=(None,))  # then nothing is read from the cache
    started = time.process_time()
    modes: FingerModes = finger_modes(finger, anonymous)
    build = time.process_time() - started
    Loop(finger, Flat(30), mechanics="modal")  # puts what is kept into the cache
    started = time.process_time()
    loop = Loop(finger, Flat(30), mechanics="modal")
    setup = time.process_time() - started
    started = time.process_time()
    for k in range(1, 1001):
        loop.step(1e-4, depth=0.001 * k)
    step = (time.process_time() - started) / 1000
    return {"build": build, "setup": setup, "step": step, "complete_hz": modes.complete}


def main(path: str) -> None:
    """Measure all, and write the report."""
    kinds = [
        (kind, Finger.subject(name, tissue=tissue, resolution="coarse"))
        for kind, tissue in RELAXATIONS.items()
        for name in SUBJECTS
    ]
    fingers = [finger for kind, finger in kinds if kind == "published"]
    record = {
        "tissue": TISSUE,
        "subjects": SUBJECTS,
        "mesh": "coarse",
        "reduced": REDUCED.tolist(),
        "vibration": [row for each in kinds for row in vibrations(*each)],
        "mesh_of_inertia": [between_meshes(kind, s) for kind in RELAXATIONS for s in SUBJECTS],
        "preload": list(preloads()),
        "ramp": [row for finger in fingers for row in ramps(finger)],
        "press": [row for each in kinds for row in presses(*each)],
        "truncation": [row for each in kinds for row in truncation(*each)],
        "last_mode": [
            finger_modes(f, operator(f, half=True)).complete * f.thickness / wave_speed(f)
            for f in fingers
        ],
        "seconds": {mesh: seconds("a.h.", mesh) for mesh in ("coarse", "standard")},
    }
    rounded = json.loads(json.dumps(record), parse_float=lambda text: float(f"{float(text):.3g}"))
    save(Path(path), rounded, "reports/modal.json")


if __name__ == "__main__":
    main(sys.argv[1])
