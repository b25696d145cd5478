"""Input out of range: every public function of theory says in a sentence what it expected."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles import fingerpad, layer, synthetic
from fefinger.validation.thesis import array
from fefinger.validation.thesis.ball import fit_ball
from fefinger.validation.thesis.claims import two_pole

from fefinger.calibration import array_sensor as sensor
from fefinger.theory import relaxation
from fefinger.theory.contact import elliptic, hertz, indentation, ting
from fefinger.theory.contact.stack import Layer, Stack
from fefinger.theory.lumped import identify
from fefinger.theory.lumped import spring as lumped
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


NAN, INF = math.nan, math.inf
TIME = np.array([0.0, 0.1, 0.2])
PRONY = Prony((0.3, 0.7), (10.0,))
SPRING = Spring(0.2, 2.0)
HERTZ = hertz.Hertz(10.0, 0.4, 34.0, 0.45)
ELLIPTIC = elliptic.Elliptic(20.0, 10.0, 0.3, 34.0, 0.4)
STACK = Stack((Layer(1.0, 100.0, 0.48), Layer(4.0, 34.0, 0.48)))
CONTACT = indentation.paraboloid(STACK, 10.0, contact_radius=2.0)
PAD = fingerpad.Fingerpad(14.0, 1.9, 1.9, PRONY)
ARRAY = sensor.ArraySensor()

CALLS = [
    lambda: hertz.relative_radius(NAN, 3.0),
    lambda: hertz.relative_radius(),
    lambda: hertz.equivalent_radius(-1.0, -2.0),
    lambda: hertz.equivalent_radius(NAN, 2.0),
    lambda: hertz.equivalent_radius(0.0, 2.0),
    lambda: fingerpad.series_modulus((NAN, 0.5)),
    lambda: fingerpad.series_modulus((10.0, 0.6)),
    lambda: fingerpad.series_modulus((10.0, NAN)),
    lambda: hertz.Hertz(NAN, 0.1, 34.0, 0.4),
    lambda: hertz.Hertz(10.0, 0.1, 34.0, 0.6),
    lambda: HERTZ.pressure(-1.0),
    lambda: HERTZ.pressure(NAN),
    lambda: HERTZ.stress(NAN, 1.0),
    lambda: ELLIPTIC.pressure(NAN, 0.0),
    lambda: Layer(NAN, 1.0, 0.3),
    lambda: Stack(()),
    lambda: STACK.kernels(NAN, 1.0),
    lambda: STACK.kernels(1.0, 9.0),
    lambda: STACK.kernels(1.0, NAN),
    lambda: CONTACT.pressure(-1.0),
    lambda: CONTACT.pressure(NAN),
    lambda: CONTACT.transform(NAN),
    lambda: indentation.paraboloid(STACK, NAN, contact_radius=1.0),
    lambda: layer.paraboloid_at(STACK, 10.0, depth=NAN),
    lambda: indentation.flat_punch(STACK, 1.0, depth=NAN),
    lambda: fingerpad.Fingerpad(NAN, 1.0, 1.0, PRONY),
    lambda: fingerpad.Fingerpad(INF, 1.0, 1.0, PRONY),
    lambda: PAD.stiffness(NAN),
    lambda: PAD.pressure(NAN, 1.0),
    lambda: PAD.force(NAN),
    lambda: PAD.depth_at(-1.0),
    lambda: PAD.depth_at(NAN),
    lambda: PAD.depth_at(INF),
    lambda: PAD.press(TIME, [0, NAN, 1.0]),
    lambda: PAD.press([], []),
    lambda: PAD.press(TIME, [-1.0, -1.0, -1.0]),
    lambda: Spring(NAN, 1.0),
    lambda: SPRING.force(NAN),
    lambda: SPRING.position(-1.0),
    lambda: SPRING.position(NAN),
    lambda: SPRING.stiffness(-1.0),
    lambda: lumped.constant_velocity(SPRING, PRONY, 1.0, 0.0),
    lambda: lumped.constant_velocity(SPRING, PRONY, NAN, 1.0),
    lambda: lumped.constant_velocity(SPRING, PRONY, 1.0, INF),
    lambda: lumped.position_under(SPRING, PRONY, TIME, [0, NAN, 1.0]),
    lambda: lumped.position_under(SPRING, PRONY, [], []),
    lambda: lumped.force(SPRING, PRONY, [], []),
    lambda: lumped.force(SPRING, PRONY, TIME, [0, 10000.0, 1.0]),
    lambda: PRONY.relaxation(-1.0),
    lambda: PRONY.relaxation(NAN),
    lambda: relaxation.hereditary_integral(PRONY, [], []),
    lambda: ting.press_by_depth(PRONY, [], [], ting.radius_nodes(1.0)),
    lambda: ting.radius_nodes(0.0),
    lambda: ting.radius_nodes(NAN),
    lambda: ting.radius_nodes(-1.0),
    lambda: ting.radius_nodes(1.0, count=0),
    lambda: relaxation.creep_integral(PRONY, TIME, [0, NAN, 0]),
    lambda: ting.press_by_force(PRONY, [0], [1], ting.ElasticForce(TIME, np.array([0, 1.0, 0.5]))),
    lambda: ting.press_by_force(PRONY, [0], [1], ting.ElasticForce(TIME, np.array([0, NAN, 1.0]))),
    lambda: sensor.ArraySensor(pitch=NAN),
    lambda: sensor.ArraySensor(elements=2.5),
    lambda: ARRAY.weights([[0.0, NAN]], [1.0]),
    lambda: ARRAY.weights([[0.0, 0.0]], [-1.0]),
    lambda: ARRAY.weights(np.zeros((0, 2)), []),
    lambda: array.scan(ARRAY, [0, 1.0], [[NAN] * 64, [1.0] * 64]),
    lambda: sensor.blurred(HERTZ.pressure, NAN, [0.0]),
    lambda: sensor.blurred(HERTZ.pressure, 1.0, [0.0], 0.0),
    lambda: two_pole([0, 0.0], [1.0, 2.0]),
    lambda: two_pole([0, 1.0], [1.0, NAN]),
    lambda: two_pole([0, 1.0], [1.0, 2.0], 0.0),
    lambda: two_pole([], []),
    lambda: sensor.fit_fingerpad([[0.1, NAN]], [[1.0, 2.0]], [0.0, 1.0]),
    lambda: fit_ball([[0.1, 0.2]], [[1.0, NAN]], [0.0, 1.0]),
    lambda: fit_ball(np.zeros((0, 2)), np.zeros((0, 2)), [0.0, 1.0]),
    lambda: fit_ball([[0.1, 0.2]], [[1.0, 1.0]], [0.0, -1.0]),
    lambda: identify.thesis([0, 1], [0, 1], [0, 1]),
]


@pytest.mark.parametrize("call", CALLS)
def test_what_is_out_of_range_gets_a_sentence(call):
    with pytest.raises(ValueError, match=r": (missing; )?expected"):
        call()


def test_terms_of_a_fit_are_counted():
    trial = synthetic.ramp_and_hold(SPRING, PRONY, hold=0.5)
    for fit in (identify.thesis, identify.joint):
        with pytest.raises(ValueError, match="terms: expected a whole number"):
            fit(trial.time, trial.position, trial.force, terms=0)
