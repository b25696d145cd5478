"""Fields by name, their units, limits and colors."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import colormaps
from refusals import refused

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import at_point, material_of
from fefinger.results.records import Fields
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Tissue
from fefinger.support.checks import InputError
from fefinger.view import frames, quantities


STRETCH = np.array([[0.02, 0.03, 0.05], [0.03, -0.04, 0.07], [0.05, 0.07, 0.01]])


def of_strain(result, strain, mechanics="linear"):
    """Return a result with one tetrahedron of skin under a strain tensor (3, 3), and 7 kPa."""
    six = strain[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    fields = Fields(
        points=np.vstack([np.zeros(3), np.eye(3)]),
        cells=np.arange(4)[None],
        region=np.ones(1, np.int8),
        times=np.zeros(1),
        displacement=np.tile([3.0, 4.0, 12.0], (1, 4, 1)),
        strain=np.tile(six, (1, 4, 1)),
        pressure=np.full((1, 4), 7.0),
    )
    response = dataclasses.replace(result.response, fields=fields, mechanics=mechanics)
    return dataclasses.replace(result, response=response)


@pytest.mark.parametrize(
    ("field", "strain", "expected"),
    [
        ("compressive strain", np.diag([0.1, -0.3, 0.2]), 30.0),
        ("compressive strain", np.diag([0.1, 0.3, 0.2]), 0.0),
        ("tensile strain", np.diag([0.1, -0.3, 0.2]), 20.0),
        ("principal strain 1", np.diag([0.1, -0.3, 0.2]), 20.0),
        ("principal strain 2", np.diag([0.1, -0.3, 0.2]), 10.0),
        ("principal strain 3", np.diag([0.1, -0.3, 0.2]), -30.0),
        ("von Mises strain", np.diag([0.2, -0.1, -0.1]), 20.0),
        ("displacement", np.eye(3), 13.0),
        ("pressure", np.eye(3), 7.0),
        ("strain xx", STRETCH, 2.0),
        ("strain yy", STRETCH, -4.0),
        ("strain zz", STRETCH, 1.0),
        ("strain xy", STRETCH, 3.0),
        ("strain yz", STRETCH, 7.0),
        ("strain xz", STRETCH, 5.0),
    ],
)
def test_fields_by_name(synthetic, field, strain, expected):
    found = quantities.values(of_strain(synthetic, strain), field, 0)
    assert found == pytest.approx([expected] * 4, abs=1e-12)


def test_every_field_has_a_unit_a_sentence_and_values(synthetic):
    assert tuple(quantities.ABOUT) == quantities.FIELDS
    for field in quantities.FIELDS:
        assert quantities.unit(field) in quantities.label(field)
        assert np.isfinite(quantities.values(synthetic, field, 1)).all()


def test_an_unknown_field_gets_the_nearest_name_and_the_list(synthetic):
    with refused("field"):
        quantities.values(synthetic, "compresive strain", 0)


def test_a_result_without_fields_says_how_to_get_them(without_fields):
    advice = r"`--set ask\.fields=true` and a mechanics that has a mesh"
    with pytest.raises(InputError, match=advice):
        quantities.values(without_fields, "strain xx", 0)


def test_principal_strains_do_not_change_with_the_frame(synthetic):
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    turned = of_strain(synthetic, turn @ np.diag([0.1, -0.3, 0.2]) @ turn.T)
    assert quantities.values(turned, "compressive strain", 0) == pytest.approx([30.0] * 4)


def test_energy_of_uniaxial_stress_is_half_stress_times_strain(synthetic):
    """In uniaxial stress W = E e² / 2, and the elastic one has the modulus E / G(infinity)."""
    finger = synthetic.scene.finger
    modulus, poisson = finger.skin.modulus, finger.skin.poisson
    pulled = of_strain(synthetic, 0.02 * np.diag([1.0, -poisson, -poisson]))
    relaxed = quantities.values(pulled, "relaxed strain energy", 0)
    assert relaxed == pytest.approx([modulus * 0.02**2 / 2] * 4)
    elastic = quantities.values(pulled, "elastic strain energy", 0)
    assert elastic == pytest.approx(relaxed / finger.prony.long_time)


@pytest.mark.parametrize(
    ("law", "exponent", "share"),
    [
        ("neo-hookean", None, None),
        ("mooney-rivlin", None, 0.3),
        ("demiray", 2.0, None),
        ("veronda-westmann", 1.5, None),
    ],
)
def test_energy_at_finite_strain_is_the_work_of_the_material_point(synthetic, law, exponent, share):
    """Along a path of stretches the stress of the finite elements does the work that is stored.

    Volume is kept, so that the pressure does none: W = integral of S : dE.
    """
    given = {k: v for k, v in {"exponent": exponent, "share": share}.items() if v is not None}
    skin = Tissue(50.0, 0.48, thickness=1.0, law=law, **given)
    finger = Finger(16.0, 11.0, skin=skin)
    result = dataclasses.replace(
        synthetic, scene=dataclasses.replace(synthetic.scene, finger=finger)
    )
    material = material_of(Elastic(50.0, 0.48), law, **given)
    logs = np.array([0.35, -0.25, -0.1])
    work = 0.0
    steps = np.linspace(0, 1, 201)
    for start, stop in pairwise(steps):
        middle = np.diag(np.expm1((start + stop) / 2 * logs))
        green = [np.expm1(2 * at * logs) / 2 for at in (start, stop)]
        work += stress(material, middle) @ (green[1] - green[0])
    shown = quantities.values(of_strain(result, np.diag(logs), "solid"), "relaxed strain energy", 0)
    assert shown == pytest.approx([work] * 4, rel=1e-4)


def stress(law, gradient):
    """Return the isochoric second Piola-Kirchhoff stress xx, yy, zz that the elements use."""
    isochoric, _ = at_point(law, gradient)
    return isochoric[:3]


@pytest.mark.parametrize(("mechanics", "rise"), [("linear", 0.3), ("solid", np.expm1(0.3))])
def test_energy_of_swelling_is_that_of_the_bulk_modulus(synthetic, mechanics, rise):
    skin = synthetic.scene.finger.skin
    bulk = skin.modulus / (3 * (1 - 2 * skin.poisson))
    swollen = of_strain(synthetic, 0.1 * np.eye(3), mechanics)
    found = quantities.values(swollen, "relaxed strain energy", 0)
    assert found == pytest.approx([bulk / 2 * rise**2] * 4)


def test_energy_from_the_strain_leaves_out_volume_near_incompressibility(synthetic):
    """Results of earlier versions have no other; K times the volume of the strain is noise."""
    skin = dataclasses.replace(synthetic.scene.finger.skin, poisson=0.4999)
    finger = dataclasses.replace(synthetic.scene.finger, skin=skin)
    scene = dataclasses.replace(synthetic.scene, finger=finger)
    swollen = of_strain(dataclasses.replace(synthetic, scene=scene), 0.1 * np.eye(3))
    assert quantities.values(swollen, "relaxed strain energy", 0) == pytest.approx([0.0] * 4)


def test_energy_that_fields_hold_is_shown_and_mirrored(synthetic):
    fields = synthetic.fields
    density = np.arange(2.0 * fields.strain[..., 0].size).reshape(*fields.strain.shape[:2], 2)
    response = dataclasses.replace(
        synthetic.response, fields=dataclasses.replace(fields, energy=density)
    )
    result = dataclasses.replace(synthetic, response=response)
    for which, field in enumerate(quantities.ENERGIES):
        assert (quantities.values(result, field, 1) == density[1, :, which]).all()
        shown = quantities.values(frames.whole_result(result), field, 1)
        assert set(shown) == set(density[1, :, which])
        assert len(shown) > len(density[1])


def test_energy_between_tissues_is_their_mean_by_volume(synthetic):
    strain = np.zeros_like(synthetic.fields.strain)
    strain[:, :, 3] = 0.1  # xy: W = 2 mu e²
    fields = dataclasses.replace(synthetic.fields, strain=strain)
    response = dataclasses.replace(synthetic.response, fields=fields)
    result = dataclasses.replace(synthetic, response=response)
    skin, inner = (
        2 * 0.01 * tissue.modulus / (2 * (1 + tissue.poisson))
        for tissue in (synthetic.scene.finger.skin, synthetic.scene.finger.subcutaneous)
    )
    found = quantities.values(result, "relaxed strain energy", 0)
    assert found.max() == pytest.approx(skin)
    assert found.min() == pytest.approx(inner)
    shared = np.intersect1d(*(fields.cells[fields.region == region] for region in (1, 2)))
    assert ((found[shared] > inner) & (found[shared] < skin)).all()


def test_colors_hold_for_all_that_is_shown():
    few, many = np.linspace(0, 3, 50), np.linspace(0, 37, 1001)
    assert quantities.span([few, many], "tensile strain")[:2] == (0.0, 40.0)
    low, high, colors, extend = quantities.span([few, -many], "strain xx")
    assert (low, high, colors, extend) == (-40.0, 40.0, quantities.DIVERGING, "neither")
    assert quantities.span([many], "strain xx", (-5.0, 10.0)).extend == "max"
    assert quantities.span([-many], "strain xx", (-5.0, 10.0)).extend == "min"
    assert quantities.span([np.zeros(4)], "pressure").high > 0


@pytest.mark.parametrize("value", [1e-7, 0.013, 1.0, 4.1, 77.8, 99.0, 12345.0])
def test_bars_end_at_the_next_round_number(value):
    top = quantities.round_up(value)
    assert value <= top <= 1.34 * value
    assert float(f"{top:.2g}") == pytest.approx(top)


def test_limits_are_read_or_refused_in_a_sentence():
    assert quantities.limits("-3.5:12") == (-3.5, 12.0)
    for bad in ("12", "a:b", "5:5", "7:3", "0:inf", ":"):
        with pytest.raises(InputError, match="--limits"):
            quantities.limits(bad)


# Machado, Oliveira and Fernandes, IEEE Trans. Vis. Comput. Graph. 15:1291 (2009), severity 1.
SIGHT = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
               [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
               [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
               [0.004733, 0.691367, 0.303900]],
}  # fmt: skip


@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize(
    "name", [quantities.EVEN, quantities.DIVERGING, quantities.SKIN_DEEP, quantities.RATES]
)
def test_color_maps_are_even_and_ordered_with_every_color_vision(name, sight):
    lab = seen(colormaps[name](np.linspace(0, 1, 33))[:, :3], np.array(SIGHT[sight]))
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    assert steps.min() > 0.8  # told apart: a just noticeable difference is about 1 at the least
    if sight == "normal":
        assert steps.max() / steps.min() < 3
    light = np.diff(lab[:, 0])
    if name == quantities.DIVERGING:
        assert (light[:15] > 0).all()
        assert (light[17:] < 0).all()
        assert np.linalg.norm(lab[0] - lab[-1]) > 60  # the two signs
    elif sight == "normal":
        assert (light > 0).all() or (light < 0).all()


def seen(rgb, matrix):
    """Return CIELAB (n, 3) of sRGB colors as somebody with that color vision sees them."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(linear @ matrix.T, 0, 1)
    to_xyz = [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
              [0.0193339, 0.1191920, 0.9503041]]  # fmt: skip
    xyz = linear @ np.transpose(to_xyz) / [0.95047, 1.0, 1.08883]
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


def test_what_the_end_colors_stand_for_is_said_where_values_lie_beyond():
    found = quantities.span([np.array([0.0, 50.0])], "compressive strain", (0.0, 40.0))
    assert found.beyond("%") == "last color: 40 % and more"
    inside = quantities.span([np.array([0.0, 50.0])], "compressive strain", (0.0, 60.0))
    assert inside.beyond("%") == ""
    both = quantities.span([np.array([-9.0, 9.0])], "strain xx", (-5.0, 5.0))
    assert both.beyond("%") == "first color: -5 % and less, last color: 5 % and more"
