"""Hyperelastic laws: published energies, derivatives, what a tissue takes, what is refused."""

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.hyperelastic.continuum import uniaxial
from fefinger.laws import LAWS, Law
from fefinger.scene import builtin
from fefinger.support.checks import InputError


VALUES = {"neo-hookean": (), "mooney-rivlin": (0.3,), "demiray": (2.0,), "veronda-westmann": (1.5,)}
PUBLISHED = {
    "neo-hookean": lambda i, j: i / 2,
    "mooney-rivlin": lambda i, j: 0.3 / 2 * i + 0.7 / 2 * j,
    "demiray": lambda i, j: (np.exp(2 * i) - 1) / 4,
    "veronda-westmann": lambda i, j: (np.exp(1.5 * i) - 1) / 1.5 - j / 2,
}
"""Published energies for a shear modulus of 1, of I1 - 3 and I2 - 3."""

pytestmark = pytest.mark.usefixtures("own_registry")


def gent(i1, i2, p):
    left = 1 - i1 / p[0]
    return -p[0] / 2 * np.log(left), 0.5 / left, 0.0, 0.5 / p[0] / left**2, 0.0, 0.0


GENT = Law("gent", gent, {"limit": None})


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_energy_is_the_published_one(name):
    i1, i2 = np.random.default_rng(0).uniform(0.0, 0.5, (2, 20))
    found = LAWS[name].at(i1, i2, VALUES[name]).w
    np.testing.assert_allclose(found, PUBLISHED[name](i1, i2), rtol=1e-12)


@pytest.mark.parametrize("law", [*LAWS.values(), GENT], ids=lambda law: law.name)
def test_derivatives_fit_the_energy(law):
    law.check(VALUES.get(law.name, (2.0,)))


def test_a_steep_law_is_not_taken_for_a_wrong_one():
    for exponent in (1e-6, 1e3, 1e5):
        LAWS["demiray"].check((exponent,))


@pytest.mark.parametrize("which", range(1, 6))
def test_a_wrong_derivative_is_found(which):
    def wrong(i1, i2, p):
        found = list(gent(i1, i2, p))
        found[which] = found[which] + 1e-3 * (i1 + i2)
        return tuple(found)

    with pytest.raises(InputError, match=r"'wrong' with limit = 2: expected d"):
        Law("wrong", wrong, {"limit": None}).check((2.0,))


@pytest.mark.parametrize(
    ("function", "what"),
    [
        (lambda i1, i2, p: (i1, 1.0, 0.0, 0.0, 0.0, 0.0), "shear modulus"),
        (lambda i1, i2, p: (i1 / 2 + 1, 0.5, 0.0, 0.0, 0.0, 0.0), "energy of 0"),
        (lambda i1, i2, p: (i1 / 2, 0.5, 0.0, np.nan, 0.0, 0.0), "received nan"),
        (lambda i1, i2, p: (i1 / 2, 0.5, 0.0), "six numbers"),
        (lambda i1, i2, p: i1.nothing, "AttributeError"),
        (lambda i1, i2: i1, "TypeError"),
    ],
)
def test_a_function_that_is_no_law_is_refused(function, what):
    with pytest.raises(InputError, match=what):
        Law("mine", function).check(())


def test_tissue_of_a_law_of_ones_own():
    ff.register(GENT)
    tissue = ff.Tissue(40.0, 0.49, law="gent", parameters={"limit": 2.0})
    assert tissue.law_values == (2.0,)
    assert tissue.stiffens
    assert not ff.Tissue(40.0, 0.49).stiffens


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"law": "gent"}, "tissue.parameters.limit: missing"),
        ({"law": "gent", "parameters": {"limit": "a"}}, "tissue.parameters.limit: expected"),
        ({"law": "gent", "parameters": {"limit": 2.0, "more": 1.0}}, "tissue.parameters.more"),
        ({"law": "gent", "parameters": {"limit": 2.0}, "exponent": 2.0}, "tissue.exponent"),
        ({"law": "demiray"}, "tissue.exponent: missing"),
        ({"law": "demiray", "exponent": 1.0, "share": 0.5}, "tissue.share: expected none"),
        ({"law": "jent"}, "Did you mean 'gent'"),
        ({"law": "hill-foam-1"}, "FEFINGER_PLUGINS"),
        ({"law": "wrong", "parameters": {"limit": 2.0}}, "tissue.law 'wrong' with limit = 2"),
    ],
)
def test_a_tissue_that_its_law_does_not_fit_is_refused(given, field):
    ff.register(GENT)
    ff.register(Law("wrong", lambda *at: (*gent(*at)[:3], 0.0, 0.0, 0.0), {"limit": None}))
    with pytest.raises(InputError, match=field):
        ff.Tissue(40.0, 0.49, **given)


def test_a_fingerprint_tells_laws_and_parameters_apart():
    other = Law("gent", lambda i, j, p: (i / 2, 0.5, 0.0, 0.0, 0.0, 0.0), {"limit": None})
    prints = {GENT.fingerprint((2.0,)), GENT.fingerprint((2.1,)), other.fingerprint((2.0,))}
    assert len(prints) == 3
    assert GENT.fingerprint((2.0,)) in prints


def coupled(i1, i2, p):
    """Fung's exponential of both invariants: every derivative differs from 0."""
    b = p[0]
    rise = np.exp(b * (i1 + i2))
    w = np.expm1(b * (i1 + i2)) / (4 * b)
    return w, rise / 4, rise / 4, b * rise / 4, b * rise / 4, b * rise / 4


COUPLED = Law("coupled", coupled, {"b": 1.5})


@pytest.mark.parametrize(
    ("law", "given"),
    [
        ("neo-hookean", {}),
        ("mooney-rivlin", {"share": 0.3}),
        ("demiray", {"exponent": 2.0}),
        ("veronda-westmann", {"exponent": 1.5}),
        (GENT, {"limit": 2.0}),
        (COUPLED, {}),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_the_tangent_of_the_elements_passes_the_taylor_test(law, given):
    assert ff.check_law(law, **given) == pytest.approx(2.0, abs=0.02)


def test_second_derivatives_that_the_energy_does_not_show_fail_the_taylor_test(monkeypatch):
    monkeypatch.setattr(Law, "check", lambda *_: None)
    wrong = Law("wrong", flawed, {"b": 1.5})
    with pytest.raises(InputError, match="Taylor remainder"):
        ff.check_law(wrong)


def flawed(i1, i2, p):
    b = p[0]
    rise = np.exp(b * (i1 + i2))
    w = np.expm1(b * (i1 + i2)) / (4 * b)
    return w, rise / 4, rise / 4, b * rise / 4, 0.0, b * rise / 4


def test_uniaxial_stress_has_the_closed_form():
    stretch = np.array([0.7, 0.9, 1.0, 1.1, 1.4])
    i1 = stretch**2 + 2 / stretch - 3
    of_gent = 2.0 / (2.0 - i1) * (stretch - stretch**-2)  # Gent, Rubber Chem. Technol. 69:59, 1996
    np.testing.assert_allclose(uniaxial(GENT, stretch, limit=2.0), of_gent, atol=1e-12)
    of_mooney = (0.3 + 0.7 / stretch) * (stretch - stretch**-2)
    found = uniaxial("mooney-rivlin", stretch, share=0.3)
    np.testing.assert_allclose(found, of_mooney, atol=1e-12)


def uncompiled(i1, i2, p):
    return i1 / 2, 0.5, 0.0 * float(np.poly1d([1.0])(0.0)), 0.0, 0.0, 0.0


def test_a_function_that_numba_does_not_compile_is_named():
    with pytest.raises(InputError, match="'uncompiled': expected a function that numba compiles"):
        ff.check_law(Law("uncompiled", uncompiled))


def test_the_planner_says_that_errors_are_not_measured():
    ff.register(GENT)
    changes = {"finger.skin.law": "gent", "finger.skin.parameters": {"limit": 0.5}}
    with pytest.raises(InputError, match=r"law of skin = 'gent': errors are not measured"):
        ff.explain("flat-press", changes=changes)
    assert "law of skin" in repr(ff.choose(scene(changes), "solid"))


def scene(changes):
    return builtin.given("flat-press", changes)
