"""Fingers whose curve is a formula, for the tests of calibration."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from fefinger.calibration import calibrate, pad_radius, press_store, search, targets
from fefinger.calibration.array_sensor import ArraySensor, blurred
from fefinger.calibration.curve import family
from fefinger.calibration.slow_press import SlowPress
from fefinger.scene import library
from fefinger.scene.indenters import Sphere


def made(exponent=1.0, radius=14.0, ratio=1.0, count=24, deepest=1.8):
    """Return a press that stiffens with the exponent, of a pad as wide as Hertz's."""
    x = deepest * np.linspace(0, 1, count + 1)[1:]
    force = 0.2 * np.sqrt(radius * ratio) * x**1.5 * np.exp((0.2 + 0.25 * exponent) * x)
    few, share = shares(radius, deepest)
    share = np.stack([np.interp(x, few, column) for column in share.T], axis=1)
    return SlowPress(x, force, force[:, None] * share, np.pi * radius * x, 1.0)


@lru_cache
def shares(radius, deepest):
    """Return depths (n,) mm and what the array feels of Hertz's pressure per newton, (n, 64)."""
    depth = deepest * np.linspace(0, 1, 25)[1:]
    return depth, np.array([read(radius * d) for d in depth.tolist()])


def read(a2):
    """Return the readings (64,) under Hertz's pressure of 1 N on a circle of area pi a2."""
    peak = 1.5e3 / (np.pi * a2)
    r = np.hypot(*ArraySensor().positions.T)
    return blurred(lambda s: peak * np.sqrt(np.maximum(1 - s**2 / a2, 0)), np.sqrt(a2), r)


def written(path, table, head="time,position,force"):
    np.savetxt(path, table, "%.7g", ",", header=head, comments="")
    return path


@pytest.fixture(scope="session")
def formula():
    """Return the function that makes a press."""
    return made


@pytest.fixture(scope="session")
def hertzian():
    """Return the function that has what the array feels of Hertz's pressure."""
    return read


@pytest.fixture(scope="session")
def write():
    """Return the function that writes a table (n, n_columns) as CSV and returns its path."""
    return written


@pytest.fixture(scope="session")
def law():
    return family((0.02, 1.5, 3.0, 5.0, 7.0), 14.0, made)


@pytest.fixture(scope="session")
def linear():
    return family((1.0,), 14.0, lambda _: made(0.0, count=400))


def ball_press(exponent, radius, ratio=1.0):
    """Return a press by a ball: of its radius, and stiffening twice as the plate's."""
    return made(2 * exponent, radius, ratio, deepest=2.0)


@pytest.fixture(scope="session")
def ball_law():
    """Return the function that makes the family under a ball of a radius in mm."""
    exponents = (0.02, 1.5, 3.0, 5.0, 7.0)
    return lambda radius: family(exponents, 14.0, lambda each: ball_press(each, radius))


@pytest.fixture(scope="session")
def by_formula():
    """Return a patch by which every press is the formula; it returns the list of what is asked."""

    def patch(patched):
        asked = []

        def answer(finger, mechanics, part=None, spare=None, indenter=None):
            small = mechanics == "condensed"
            exponent = 0.0 if small else finger.subcutaneous.exponent
            ratio = finger.skin.modulus / finger.subcutaneous.modulus / library.SKIN_RATIO
            asked.append((mechanics, finger.resolution, finger.pad_radius, exponent, ratio))
            if isinstance(indenter, Sphere):
                return ball_press(exponent, indenter.radius, ratio)
            return made(exponent, finger.pad_radius, ratio, 400 if small else 24, 2.0)

        def of_its_modulus(finger, mechanics, part, indenter):
            found = answer(finger, mechanics, part, indenter=indenter)
            return replace(found, force=finger.subcutaneous.modulus / 34 * found.force)

        patched.setattr(press_store, "press", answer)
        patched.setattr(calibrate, "press", of_its_modulus)
        patched.setattr(
            press_store, "small", lambda finger, of: answer(finger, "condensed", indenter=of)
        )
        patched.setattr(pad_radius, "thesis_fit", by_width)
        return asked

    return patch


@pytest.fixture
def solved(by_formula, monkeypatch):
    """Let every press be the formula; return the list of what was asked."""
    return by_formula(monkeypatch)


@pytest.fixture(scope="session")
def start_once():
    """Return a patch by which fits have one start instead of four."""
    starts = targets.Forces.starts

    def patch(patched):
        patched.setattr(targets.Forces, "starts", lambda self: starts(self)[1:2])

    return patch


@pytest.fixture
def one_start(start_once, monkeypatch):
    """Fit from one start."""
    start_once(monkeypatch)


@pytest.fixture
def plain_rig(monkeypatch, one_start):
    """Leave out the fits of what rigs rarely do too, where they are not the question."""
    monkeypatch.setattr(search, "with_rare", lambda result, *_: result)


def by_width(frames):
    """Return R from the mean square distance 2 a² / 5 + 2 sigma² of Hertz's blurred pressure."""
    last, depth = frames.pressure[-1], frames.depth[-1, 0]
    square = float(last @ frames.distance**2 / last.sum()) - 2 * 0.96**2
    return pad_radius.PadFit(2.5 * square / depth, 1.0, 1.0, 0.0)
