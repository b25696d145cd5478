"""Tissue of a file that was fitted to a finger of another size is told."""

from dataclasses import replace
from pathlib import Path

import fefinger as ff
from fefinger.results import key_numbers
from fefinger.scene.finger import other_size


FITTED = """
width = 15.0
thickness = 11.0
[skin]
modulus = 30.0
poisson = 0.48
thickness = 1.0
[subcutaneous]
modulus = 3.0
poisson = 0.48
"""


def test_tissue_of_a_finger_of_another_size_is_a_caution(
    tmp_path: Path, synthetic: ff.Result
) -> None:
    file = tmp_path / "tissue.toml"
    file.write_text(FITTED)
    tissue = str(file)
    assert other_size(ff.Finger(15, 11, tissue=tissue)) == ()
    assert other_size(ff.Finger.subject("a.h.")) == ()
    (note,) = other_size(ff.Finger.subject("a.h.", tissue=tissue))
    assert "another size, 15 mm wide and 11 mm thick; this one is 14 mm wide and 10 mm th" in note
    file.write_text(FITTED.replace("thickness = 11.0", ""))
    (note,) = other_size(ff.Finger(14, 11, tissue=tissue))
    assert "another size, 15 mm wide; this one" in note
    scene = replace(synthetic.scene, finger=ff.Finger(14, 11, tissue=tissue))
    result = ff.Result.of(scene, synthetic.plan, synthetic.response)
    assert key_numbers.cautions(result)[-1] == f"t{note[1:-1]}"
    file.unlink()  # as of a result that is read elsewhere
    assert note in result.notes
    assert not any("another size" in caution for caution in key_numbers.cautions(result))
