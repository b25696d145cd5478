"""Soft plates, balls and cylinders: their keys, words and refusals."""

import math

import pytest

import fefinger as ff
from fefinger.scene.toml import tables
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


def scene(indenter: str, motion: str = 'kind = "ramp"\nspeed = 10\ndepth = 0.5') -> ff.Scene:
    finger = "[finger]\nwidth = 15\nthickness = 11\n"
    return ff.Scene.from_toml(f"{finger}[indenter]\n{indenter}\n[motion]\n{motion}\n")


def test_a_soft_object_is_read_written_and_named() -> None:
    made = scene('kind = "sphere"\nradius = 6\nmodulus = 50\npoisson = 0.45\nthickness = 2')
    # exact: numbers as they are written
    assert made.indenter == ff.Sphere(6, modulus=50, poisson=0.45, thickness=2)
    again = ff.Scene.from_toml(made.to_toml())
    assert again.indenter == made.indenter  # exact: numbers that are written are read
    assert made.indenter.describe() == (
        "a soft sphere of 50 kPa (2 mm thick on a rigid base), radius 6 mm"
    )
    assert ff.Flat(30, modulus=50).describe() == "a soft flat plate of 50 kPa at 30 degrees"
    assert ff.Cylinder(4, modulus=8).describe().startswith("a soft cylinder of 8 kPa, radius 4 mm")
    assert ff.Flat(30, modulus=50) != ff.Flat(30)
    assert ff.Flat(30, modulus=50).signature != ff.Flat(30, modulus=60).signature


def test_an_object_that_relaxes_is_read_written_and_named() -> None:
    text = 'kind = "sphere"\nradius = 6\nmodulus = 50\nprony = {c = [0.6, 0.4], v = [2.0]}'
    made = scene(text)
    prony = Prony((0.6, 0.4), (2.0,))
    # exact: numbers as they are written
    assert made.indenter == ff.Sphere(6, modulus=50, prony=prony)
    again = ff.Scene.from_toml(made.to_toml())
    assert again.indenter == made.indenter  # exact: numbers that are written are read
    assert made.indenter.describe() == "a soft sphere of 50 kPa relaxed, radius 6 mm"
    assert made.indenter.soft_prony == prony
    assert ff.Sphere(6, modulus=50).soft_prony.long_time == 1.0  # exact: it does not relax
    assert made.indenter.signature != ff.Sphere(6, modulus=50).signature


def test_a_rigid_object_has_the_text_that_it_had() -> None:
    for rigid in (ff.Flat(30), ff.Sphere(6), ff.Cylinder(4)):
        assert rigid.soft_body is None
        assert rigid.describe().startswith("a rigid")
        assert rigid.signature == repr(rigid)
        made = scene('kind = "flat"')
        table = tables(made.finger, rigid, made.motion, made.ask)["indenter"]
        assert not {"modulus", "poisson", "thickness", "prony"} & table.keys()


def test_the_body_of_a_soft_object_is_a_layer_or_a_half_space() -> None:
    body = ff.Flat(30, modulus=50).soft_body
    assert body is not None
    assert body.layers[0].thickness == math.inf
    assert body.surface == (50, 0.5)
    layer = ff.Flat(30, modulus=50, thickness=3, poisson=0.3).soft_body
    assert layer is not None
    assert layer.thickness == 3


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ("modulus = 0", "indenter.modulus"),
        ("modulus = -5", "indenter.modulus"),
        ("modulus = nan", "indenter.modulus"),
        ("modulus = inf", "indenter.modulus"),
        ("modulus = 50\npoisson = 0", "indenter.poisson"),
        ("modulus = 50\npoisson = 0.6", "indenter.poisson"),
        ("modulus = 50\npoisson = nan", "indenter.poisson"),
        ("modulus = 50\nthickness = 0", "indenter.thickness"),
        ("modulus = 50\nthickness = 7", "indenter.thickness"),  # of a ball of 6 mm
        ("modulus = 50\nfriction = 0.5", "indenter.friction"),
        ("poisson = 0.4", "indenter.modulus"),
        ("thickness = 2", "indenter.modulus"),
        ("prony = {c = [0.5, 0.5], v = [1]}", "indenter.modulus"),
        ("modulus = 50\nprony = {c = [0.5, 0.4], v = [1]}", "indenter.prony.c"),
        ("modulus = 50\nprony = {c = [0.5, 0.5], v = [0]}", "indenter.prony.v"),
        ("modulus = 50\nprony = {c = [0.5, 0.5], v = []}", "indenter.prony"),
        ("modulus = 50\nprony = {c = [1]}", "indenter.prony.v"),
        ("modulus = 50\nprony = 3", "indenter.prony"),
    ],
)
def test_a_bad_number_is_refused_in_a_sentence(given: str, field: str) -> None:
    with pytest.raises(InputError) as error:
        scene(f'kind = "sphere"\nradius = 6\n{given}')
    assert str(error.value).startswith(f"{field}: ")
    assert "expected" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("kind", ["bar", "pin", "dots", "grating", "ellipsoid"])
def test_sharp_objects_and_reliefs_are_not_soft(kind: str) -> None:
    with pytest.raises(InputError) as error:
        scene(f'kind = "{kind}"\nmodulus = 50')
    assert "modulus" in str(error.value)
    assert "'sphere'" in str(error.value)  # which can be
