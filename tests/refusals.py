"""Errors of input, checked by the field that they name."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from fefinger.support.checks import InputError


@contextmanager
def refused(field: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """Expect an InputError that names this field."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert caught.value.field == field
