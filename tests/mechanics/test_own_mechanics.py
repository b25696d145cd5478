"""A mechanics of a user's own: listed, run by name, saved; answers that fit nothing are refused."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, SIMPLEST
from fefinger.results.records import Response
from fefinger.support import registry
from fefinger.support.checks import InputError


CHANGES = {"motion.depth": 0.5, "ask.pressure": False, "ask.strain": False, "ask.spikes": []}
N = 5

pytestmark = pytest.mark.usefixtures("own_registry")


class Springs(ff.Mechanics):
    """A force of 1 N/mm."""

    name = "springs"

    def cost(self, case):
        return 1e-3

    def respond(self, scene, progress=None):
        time = Situation.of(scene).times
        depth = scene.motion.value(time)
        return answer(time=time, depth=depth, force=1.0 * depth)


def answer(**arrays):
    return Response(mechanics="springs", status="exact", seconds={}, notes=(), **arrays)


def test_it_is_listed_with_an_error_that_is_not_known_and_not_chosen():
    ff.register(Springs)
    plan = ff.explain("flat-press", changes=CHANGES)
    assert plan.mechanics != "springs"
    rung = next(rung for rung in plan.rungs if rung.mechanics == "springs")
    assert np.isnan(rung.error)
    assert rung.refusals[0].reason == "its error here is not known"


def test_it_runs_by_name_and_its_result_is_saved_and_read_without_it(tmp_path):
    ff.register(Springs())
    result = ff.run("flat-press", changes=CHANGES, mechanics="springs")
    np.testing.assert_array_equal(result.force, result.depth)  # exact: a spring of 1 N/mm
    assert "springs" in str(result)
    result.save(tmp_path)
    del registry.MECHANICS._things["springs"]
    assert MECHANICS["springs"] == SIMPLEST
    again = ff.load(tmp_path)
    np.testing.assert_array_equal(again.force, result.force)  # exact: a file keeps every bit
    assert "springs" in str(again)
    with refused("mechanics"):
        ff.run("flat-press", changes=CHANGES, mechanics="springs")


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"force": np.ones(N - 1)}, "a force of shape"),
        ({"depth": np.ones((N, 1))}, "a depth of shape"),
        ({"contact_area": np.ones(3)}, "a contact_area of shape"),
        ({"centroid": np.ones((N, 3))}, "a centroid of shape"),
        ({"force": np.full(N, np.nan)}, "a finite force"),
        ({"time": np.arange(N)[::-1]}, "times that increase"),
    ],
)
def test_arrays_that_do_not_fit_are_named(monkeypatch, arrays, sentence):
    whole = {"time": np.arange(N), "depth": np.ones(N), "force": np.ones(N)} | arrays
    monkeypatch.setattr(Springs, "respond", lambda *_: answer(**whole))
    ff.register(Springs)
    with pytest.raises(InputError, match=sentence):
        ff.run("flat-press", changes=CHANGES, mechanics="springs")


def test_what_is_no_response_is_named(monkeypatch):
    monkeypatch.setattr(Springs, "respond", lambda *_: 3.0)
    ff.register(Springs)
    with pytest.raises(InputError, match="expected a Response"):
        ff.run("flat-press", changes=CHANGES, mechanics="springs")


@pytest.mark.parametrize(
    ("method", "returned", "sentence"),
    [
        ("cost", "soon", "mechanics 'springs' failed with TypeError"),
        ("error", 0.1, "mechanics 'springs' failed with TypeError"),
        ("refuse", 5, "mechanics 'springs' failed with TypeError"),
        ("respond", None, r"failed with ZeroDivisionError.* \(line \d+ of .*test_own_mechanics\)"),
    ],
)
def test_a_method_that_fails_or_returns_another_type_is_an_error_of_that_mechanics(
    monkeypatch, method, returned, sentence
):
    def fails(*_):
        return returned if returned is not None else 1 / 0

    monkeypatch.setattr(Springs, method, fails)
    ff.register(Springs)
    with pytest.raises(InputError, match=sentence):
        ff.run("flat-press", changes=CHANGES, mechanics="springs")


def test_traits_of_another_type_are_refused(monkeypatch):
    monkeypatch.setattr(Springs, "traits", 7, raising=False)
    ff.register(Springs)
    with pytest.raises(InputError, match="traits"):
        ff.run("flat-press", changes=CHANGES, mechanics="springs")


def test_a_name_that_is_taken_is_refused(monkeypatch):
    monkeypatch.setattr(Springs, "name", "hertz")
    with refused("mechanics.name"):
        ff.register(Springs)


def test_a_class_without_an_answer_is_no_mechanics():
    class Half(ff.Mechanics):
        name = "half"

    with refused("register"):
        ff.register(Half)
