"""Studies in tests are answered in this process, which has everything loaded already."""

import pytest

from fefinger.studies import study, tasks


REAL = tasks.local


def _here(scenes, workers=None):
    """Answer tasks one after the other."""
    yield from ((number, tasks.answer(task)) for number, task in enumerate(scenes))


@pytest.fixture(scope="package", autouse=True)
def _in_this_process():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(study, "local", _here)
        yield


@pytest.fixture
def words_alone(monkeypatch):
    """Leave drawings out of the page of a study, where its words are the question."""
    monkeypatch.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")


@pytest.fixture
def child_processes(monkeypatch):
    """Answer the scenes of a study in child processes, as a user's are."""
    monkeypatch.setattr(study, "local", REAL)
