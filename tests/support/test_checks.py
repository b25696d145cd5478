"""The sentences that unusable input gets."""

import pickle

import numpy as np
import pytest
from refusals import refused

from fefinger.support.checks import (
    LONG_VALUE,
    LONGEST,
    InputError,
    boolean,
    choice,
    choices,
    instance,
    integer,
    number,
    numbers,
    reject_unknown,
    suggestion,
)


@pytest.mark.parametrize("value", [2, 2.5, np.float32(2.5), np.int64(2), np.array(2.5)])
def test_a_number_comes_back_as_a_float(value):
    result = number("x", value, above=1, at_most=3)
    assert type(result) is float
    assert result == float(value)


@pytest.mark.parametrize(
    ("value", "limits", "message"),
    [
        ("2", {}, r"x: expected a finite number, received '2'"),
        (True, {}, r"x: expected a finite number, received True"),
        (None, {}, r"received None"),
        ([2], {}, r"received \[2\]"),
        (1j, {}, r"received 1j"),
        (float("nan"), {}, r"received nan"),
        (float("inf"), {"unit": "mm"}, r"expected a finite number in mm, received inf"),
        (1, {"above": 1}, r"expected a finite number above 1, received 1"),
        (0.9, {"at_least": 1, "at_most": 2}, r"number at least 1 and at most 2, received 0.9"),
        (2, {"below": 2, "unit": "s"}, r"number in s below 2, received 2"),
    ],
)
def test_what_is_no_number_in_range_is_named_with_what_was_expected(value, limits, message):
    with pytest.raises(InputError, match=message):
        number("x", value, **limits)


def test_nearest_suggests_only_what_is_near():
    assert suggestion("sped", ("speed", "depth")) == " Did you mean 'speed'?"
    assert suggestion("zzz", ("speed", "depth")) == ""
    assert (
        suggestion("ball", ("sphere", "braille"), {"ball": "sphere"}) == " Did you mean 'sphere'?"
    )


def test_a_choice_is_passed_on_or_refused_with_the_options():
    assert choice("kind", "flat", ("flat", "sphere")) == "flat"
    with pytest.raises(InputError, match=r"kind: expected one of .flat., .sphere., received"):
        choice("kind", "spher", ("flat", "sphere"))
    with pytest.raises(InputError, match=r"received 3"):
        choice("kind", 3, ("flat",))


@pytest.mark.parametrize("value", [0, 1, "true", None, np.array([True]), np.array([True, False])])
def test_a_flag_is_true_or_false_and_nothing_else(value):
    assert boolean("x", True) is boolean("x", np.True_) is True
    with pytest.raises(InputError, match="x: expected true or false"):
        boolean("x", value)


@pytest.mark.parametrize("value", [2, np.int64(2), np.uint8(2), np.array(2)])
def test_a_whole_number_of_numpy_is_one(value):
    assert type(integer("n", value, at_least=2)) is int


@pytest.mark.parametrize("value", [True, np.True_, 1, np.int8(1), 2.0, "3", None, np.array([2])])
def test_a_whole_number_is_no_truth_value_and_no_float(value):
    with pytest.raises(InputError, match=r"n: expected a whole number of 2 or more, received"):
        integer("n", value, at_least=2)


def test_unknown_keys_are_named_with_their_table():
    reject_unknown("motion", {"speed": 1}, ("speed",))
    with pytest.raises(InputError, match=r"sped: unknown key in \[motion\]. Did you mean 'speed'"):
        reject_unknown("motion", {"sped": 1}, ("speed",))


def test_lists_are_checked_entry_by_entry():
    assert numbers("x", np.array([1, 2]), count=2, above=0) == (1.0, 2.0)
    assert choices("x", ["a", "b"], ("b", "a")) == ("a", "b")
    with pytest.raises(InputError, match=r"x\[1\]: .*received 'b'"):
        numbers("x", [1, "b"])
    with pytest.raises(InputError, match=r"x: expected a list of 3 numbers, received 2: "):
        numbers("x", [1, 2], count=3)
    with pytest.raises(InputError, match=r"x: expected a list of numbers, received 3"):
        numbers("x", 3)
    with pytest.raises(InputError, match=r"x\[0\]: expected one of 'b'"):
        choices("x", ["a"], ("b",))
    with pytest.raises(InputError, match=r"x: expected every name once"):
        choices("x", ["b", "b"], ("b",))


FIELDS = {
    "motion.depth": lambda: number("motion.depth", 0, above=0),
    "indenter.at[1]": lambda: numbers("indenter.at", [0, "y"]),
    "--type": lambda: choice("--type", "SA", ("SAI",)),
    "motion.sped": lambda: reject_unknown("motion", {"sped": 1}, ("speed",)),
    "nam": lambda: reject_unknown("", {"nam": 1}, ("name",)),
    "ask.seed": lambda: integer("ask.seed", -1),
    "ask.fields": lambda: boolean("ask.fields", 1),
}


@pytest.mark.parametrize(("field", "check"), FIELDS.items(), ids=FIELDS)
def test_an_error_knows_its_field(field, check):
    with refused(field) as refusal:
        check()
    assert pickle.loads(pickle.dumps(refusal.value)).field == field


@pytest.mark.parametrize(
    ("message", "field"),
    [
        ("time, drive: expected finite values", "time"),
        ("reference.strain, reference.normals: expected (3, 3, 3)", "reference.strain"),
        ("--over motion.depth=1:2:0: expected FIELD=START:STOP:COUNT", "--over"),
        ("law gent: expected six numbers", "law"),
        ("mechanics winkler: expected times that increase", "mechanics"),
    ],
)
def test_of_several_fields_an_error_knows_the_first_and_of_a_named_thing_what_it_is(message, field):
    assert InputError(message).field == field


def test_an_error_without_a_field_has_none():
    assert InputError("output folder: expected a name").field == ""
    assert InputError("nothing is known").field == ""


def test_a_message_is_printable_and_its_lines_are_short():
    error = InputError(f"x: received '{'y' * 100_000}'; take less\n\x1b[2J\u202e² é {'z' * 100}")
    first, second = str(error).splitlines()
    assert first.startswith("x: received 'yyy")
    assert first.endswith("y'; take less")
    assert len(first) <= LONGEST
    assert second == "\\x1b[2J\\u202e² é " + "z" * 100


@pytest.mark.parametrize("value", ["y" * 100_000, ["a b"] * 10_000, {"a": "b " * 10_000}])
def test_a_long_value_is_shown_by_its_ends(value):
    with pytest.raises(InputError) as told:
        boolean("x", value)
    assert len(str(told.value)) < 2 * LONG_VALUE
    assert " [...] " in str(told.value)
    assert len(str(InputError(f"x: received {'y' * 100_000!r}, no folder"))) < 2 * LONG_VALUE


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: number("x", np.eye(2)), "received array([[1., 0.], [0., 1.]])"),
        (lambda: choice("x", np.zeros(2), ("a", "b")), "one of 'a', 'b', received array"),
        (lambda: integer("x", 5, at_least=1, at_most=4), "a whole number of 1 to 4, received 5"),
        (lambda: instance("x", 5, list, "a list"), "x: expected a list, received 5"),
    ],
)
def test_values_of_another_class_are_told_in_one_line(check, message):
    with pytest.raises(InputError) as refused:
        check()
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_whole_numbers_of_thousands_of_digits_are_refused():
    value = -(10**5000)
    for check in (number, boolean, numbers, lambda name, value: choice(name, value, ("a",))):
        with pytest.raises(InputError, match="a int that is too long to print"):
            check("x", value)
    with pytest.raises(InputError, match="a int that is too long to print"):
        integer("x", value)


def test_numbers_that_overflow_or_vanish_when_multiplied_are_refused():
    assert number("x", 1e-300) == 1e-300  # a sample that decays
    assert numbers("x", [1e-300, 1e30]) == (1e-300, 1e30)
    for value, limits in ((1e-300, {"above": 0}), (-1e300, {}), (1e300, {"above": 0})):
        with pytest.raises(InputError, match=r"at least \S*e.30 and at most 1e\+30, received"):
            number("x", value, **limits)
    with pytest.raises(InputError, match=r"x\[1\]"):
        numbers("x", [1.0, 1e300])
    with pytest.raises(InputError, match=r"at most 1, received 1e\+300"):
        number("x", 1e300, at_most=1)


def test_a_number_that_is_too_large_is_told_the_limits_that_hold():
    with pytest.raises(InputError, match=r"at least 0 and at most 1e\+30, received 1e\+300"):
        number("days", 1e300, at_least=0.0)
