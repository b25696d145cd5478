"""What a finger yields beyond its layers: against elements, and what it may not change."""

from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics import layered, linear
from fefinger.mechanics.press import beyond_layers, layer_press
from fefinger.mechanics.press.layer_grid import LayerGrid
from fefinger.scene.indenters import Flat
from fefinger.support.progress import Stages


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
ASK = ff.Ask(spikes=(), fields=False, strain=False)
LAYERS = LayerGrid(layered.stack(FINGER), 96, 0.14, width=1.5)


def press(indenter, depth=None, force=None):
    """Return a press that stands at its depth or its force."""
    twice = {name: value and (value, value) for name, value in (("depth", depth), ("force", force))}
    return ff.Scene(
        finger=FINGER, indenter=indenter, motion=ff.Sampled((0.0, 0.1), **twice), ask=ASK
    )


def alone(scene):
    """Answer of flat layers on flat bone, without what the finger yields beyond."""
    grid = layered.grid(scene.finger, scene.indenter, scene.motion, scene.ask)
    return layer_press.respond(scene, grid, lambda: None, Stages(None), mechanics="", notes=())


@pytest.mark.parametrize(
    "indenter",
    [
        ff.Flat(15.0),
        ff.Bar(3.0, 0.4),
        ff.Bar(3.0, 0.4, roll=90.0),
        ff.Cylinder(5.0),
        ff.Pin(4.0, 0.4),
        ff.Grating(3.0, 1.5, 0.5, angle=0.0),
    ],
    ids=lambda indenter: indenter.kind,
)
def test_forces_are_those_of_elements_where_the_layers_alone_are_too_stiff(indenter):
    scene = press(indenter, depth=0.8)
    elements = linear.respond(scene)
    high = elements.force.max()
    errors = [
        abs(each.force.max() / high - 1.0)
        for each in (alone(scene), layered.respond_on_grid(scene))
    ]
    assert errors[1] < min(0.2, errors[0])


def test_under_a_force_it_moves_the_object_alone():
    scene = press(ff.Bar(3.0, 0.4), force=0.3)
    whole, layers = layered.respond(scene), alone(scene)
    assert whole.force == pytest.approx(layers.force, abs=1e-9)
    assert whole.pressure == pytest.approx(layers.pressure, abs=1e-3 * layers.pressure.max())
    assert whole.contact_area[-1] == pytest.approx(layers.contact_area[-1], rel=2e-3)
    yields = beyond_layers.compliance(
        beyond_layers.alone(FINGER), layered.stack(FINGER), ff.Sphere(8.0)
    )
    assert yields > 1e-4
    # At once all tissue is stiffer by G(0) / G(infinity), as the layers are.
    end = whole.depth[-1] - layers.depth[-1]
    relaxed = FINGER.prony.long_time
    assert 1e3 * 0.3 * yields * relaxed < end < 1e3 * 0.3 * yields


def test_the_mean_displacement_is_that_of_the_body_below():
    rng = np.random.default_rng(2)
    pressure = rng.random((96, 96))
    borne = replace(LAYERS, beyond=3e-4)
    moved = [
        np.fft.irfft2(np.fft.rfft2(pressure) * each.compliance, (96, 96))
        for each in (LAYERS, borne)
    ]
    force = pressure.sum() * LAYERS.spacing**2
    assert moved[1] - moved[0] == pytest.approx(3e-4 * force, rel=1e-9)


def test_a_finger_of_three_times_the_moduli_yields_a_third():
    soft = beyond_layers.alone(FINGER)
    layers = {name: getattr(soft, name) for name in ("skin", "subcutaneous")}
    stiffer = {name: replace(each, modulus=3 * each.modulus) for name, each in layers.items()}
    one, other = (
        beyond_layers.compliance(each, layered.stack(each), Flat(30.0))
        for each in (soft, replace(soft, **stiffer))
    )
    assert other == pytest.approx(one / 3, rel=1e-6)


def test_a_finger_without_a_mesh_has_its_layers_alone_and_says_so():
    squat = replace(FINGER, width=20.0, thickness=8.5)
    with pytest.raises(ff.InputError):
        beyond_layers.compliance(beyond_layers.alone(squat), layered.stack(squat), Flat(30.0))
    scene = replace(press(ff.Bar(3.0, 0.4), depth=0.3), finger=squat)
    answer = layered.respond(scene)
    assert any("the stated error does not hold" in note for note in answer.notes)
    assert answer.force == pytest.approx(alone(scene).force, rel=1e-12)
