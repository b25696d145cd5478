"""`fefinger view`: what it lists, refuses and says."""

import pytest

from fefinger.__main__ import main
from fefinger.view import quantities


def test_the_command_lists_the_fields(saved, capsys):
    assert main(["view", "out", "--field", "list"]) == 0
    assert [line.split(":")[0] for line in capsys.readouterr().out.splitlines()] == list(
        quantities.FIELDS
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--field", "stress"], "--field: expected one of 'compressive strain', 'tensile strain'"),
        (["--field", "SED"], "Did you mean 'elastic strain energy' or 'relaxed strain energy'?"),
        (["--field", "Compressive Strain"], "Did you mean 'compressive strain'?"),
        (["--field", "von_mises"], "Did you mean 'von Mises strain'?"),
        (["--time", "99"], "--time: expected a time within the run, from 0 to 5 s, received 99 s"),
        (["--time", "-1"], "--time: expected a finite number in s at least 0, received -1"),
        (["--time", "nan"], "--time: expected a finite number in s at least 0, received nan"),
        (["--limits", "3"], "--limits: expected LOW:HIGH, such as 0:30, received '3'"),
        (["--movie", "a.avi"], "--movie: expected a file that ends in .gif or .mp4"),
    ],
)
def test_the_command_refuses_in_a_sentence(saved, capsys, words, message):
    assert main(["view", "out", *words]) == 2
    assert message in capsys.readouterr().err


def test_the_command_says_which_time_is_shown(saved, tmp_path, capsys):
    fields = saved.fields
    page = ["--html", str(tmp_path / "a.html")]
    assert main(["view", "out", "--time", "2.4", *page]) == 0
    assert capsys.readouterr().err == (
        f"out: shown at {fields.times[1]:.6g} s, the nearest to 2.4 s of its 3 stored times\n"
    )
    assert main(["view", "out", "--time", str(fields.times[1]), *page]) == 0
    assert capsys.readouterr().err == ""
