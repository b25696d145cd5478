"""The array on a response: what it reads of hertz is the blurred Hertz pressure."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.thesis import array
from refusals import refused

import fefinger as ff
from fefinger.calibration.array_sensor import ArraySensor, blurred, plane
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


ASK = ff.Ask(strain=False, fields=False)
FINGER = ff.Finger.subject("a.h.", prony=Prony((1.0,), ()), tissue="maeno1998")
SCENE = ff.Scene(finger=FINGER, motion=ff.RampHold(5, 1.0, hold=0.5), ask=ASK)


@pytest.fixture(scope="module")
def result():
    return ff.run(SCENE, mechanics="hertz")


def test_the_readings_are_the_blurred_pressure_of_hertz(result):
    sensor = ArraySensor()
    last = array.read(result).pressure[-1]
    peak = 1.5e3 * result.force[-1] / (np.pi * 14.0)

    def hertz(r):
        return peak * np.sqrt(np.maximum(1 - r**2 / 14.0, 0))

    want = blurred(hertz, np.sqrt(14.0), np.hypot(*sensor.positions.T))
    assert last == pytest.approx(want, abs=0.01 * peak)
    assert last @ sensor.positions / last.sum() == pytest.approx([0, 0], abs=1e-6)


def test_an_angled_plate_sees_the_same_circle(result):
    steep = replace(SCENE, indenter=ff.Flat(angle=40, tilt=5))
    reading = array.read(ff.run(steep, mechanics="hertz"))
    assert reading.pressure[-1] == pytest.approx(array.read(result).pressure[-1], abs=1e-2)


def test_distal_is_x_and_the_noise_is_seeded(result):
    points = plane(SCENE.indenter, result.pad.points)
    offset = result.pad.points - result.pad.points[0]
    across = np.abs(offset[:, 1]) < 1e-9
    assert np.corrcoef(points[across, 0], offset[across, 0])[0, 1] > 0.99
    one, two = (array.read(result, seed=s).pressure for s in (1, 1))
    assert (one == two).all()  # exact: one seed, twice
    assert np.std(one - array.read(result).pressure) == pytest.approx(0.5, rel=0.03)


def test_what_cannot_be_read_gets_a_sentence(result):
    with refused("ask.pressure"):
        array.read(ff.run(replace(SCENE, ask=replace(ASK, pressure=False)), mechanics="hertz"))
    with pytest.raises(InputError, match="expected a plate"):
        array.read(ff.run(replace(SCENE, indenter=ff.Sphere(5.0)), mechanics="hertz"))
    with pytest.raises(InputError, match="sensor: areas"):
        array.read(result, ArraySensor(sigma=0.002))
