"""One finger, whose press is shipped, for the tests of the page."""

import pytest

from fefinger.live.player import Player, Setup
from fefinger.mechanics.loop import Loop


@pytest.fixture(scope="session")
def loop() -> Loop:
    return Setup().loop("coarse")


@pytest.fixture
def player(loop: Loop) -> Player:
    return Player(Setup(), loop)
