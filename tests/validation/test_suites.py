"""What holds of the cases of every suite, before any of them is measured."""

import pytest
from fefinger.validation import suites


@pytest.mark.parametrize("suite", suites.SUITES)
def test_names_are_distinct_and_every_case_has_a_source_and_a_tolerance(suite):
    cases = suites.cases(suite, quick=False)
    assert len({case.name for case in cases}) == len(cases)
    assert [case.name for case in cases if not case.source] == []
    assert [case.name for case in cases if not case.expected.tolerance >= 0] == []


@pytest.mark.parametrize("suite", suites.SUITES)
def test_the_quick_cases_have_different_names(suite):
    names = [case.name for case in suites.cases(suite, quick=True)]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("suite", suites.SUITES)
def test_whatever_differs_from_the_print_or_from_what_is_wanted_says_why(suite):
    for case in suites.cases(suite, quick=False):
        for other, why in ((case.printed, case.erratum), (case.wanted, case.shortfall)):
            if other is not None and abs(other - case.expected.value) > case.expected.tolerance:
                assert why, case.name


@pytest.mark.parametrize("suite", suites.SUITES)
def test_only_what_is_counted_has_no_tolerance(suite):
    """No verdict may hang on how a processor rounds."""
    cases = suites.cases(suite, quick=False)
    counted = [case.expected.value for case in cases if case.expected.tolerance == 0]
    assert counted == [round(value) for value in counted]


@pytest.mark.parametrize("suite", ["fem", "neural"])
def test_every_tolerance_has_its_reason(suite):
    for quick in (True, False):
        assert [case.name for case in suites.cases(suite, quick=quick) if not case.reason] == []
