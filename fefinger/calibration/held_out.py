"""Prediction of a press or motion that was not fitted, with its error."""

from dataclasses import dataclass, replace

import numpy as np

from fefinger.calibration.curve import ForceLaw, curve
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration, PressFit, plain
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.records_target import RecordsTarget, indenters, presses
from fefinger.calibration.rig import lagged
from fefinger.calibration.slow_press import press
from fefinger.calibration.targets import TOUCH, errors
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.tissue import Tissue
from fefinger.support.arrays import Array
from fefinger.theory.lumped.ramp_hold import smooth


SHOWS = 0.01
"""Part of the largest force from which it shows that an object touches."""


@dataclass(frozen=True)
class Held:
    """A record that is predicted: time s, position mm, force N (n_t,), and what presses."""

    name: str
    time: Array
    position: Array
    force: Array
    indenter: Indenter

    @property
    def shows(self) -> float:
        """Position in mm at which the force first shows."""
        touched = smooth(self.force) > SHOWS * float(self.force.max())
        return float(self.position[int(np.argmax(touched))])


def checked(
    done: Calibration, work: Work, held: Held, fitted: RecordTarget | RecordsTarget
) -> Calibration:
    """Add the prediction of a record that was not fitted, and its errors.

    What the rig does is taken from the first record that was fitted, and so is touch. Under an
    object that no record has, the fitted finger is pressed anew on the final mesh, and touch is
    where the prediction is best.
    """
    law, x0 = done.law, done[TOUCH].value
    if held.indenter != indenters(fitted)[0]:
        law = _law(done, work, held)
        x0 = _touch(done, law, held, fitted)
    model = _seen(done, law, held, fitted, x0)
    check = {"record that was not fitted": errors(held.force, model)}
    # As many averages where it moves as in time.
    gone = np.append(0.0, np.cumsum(np.abs(np.diff(smooth(held.position)))))
    part = gone / gone[-1] + np.linspace(0, 1, len(gone))
    averages = 400  # largest number of averages that are kept for a page
    starts = np.unique((part * averages / 2).astype(int), return_index=True)[1]
    size = np.diff([*starts.tolist(), len(gone)])
    rows = [
        plain(np.add.reduceat(each, starts) / size)
        for each in (held.time, held.position - x0, held.force, model)
    ]
    shown = PressFit(held.name, rows[0], rows[1], rows[2], rows[3], held_out=True)
    return replace(
        done,
        checks=done.checks | check,
        presses=(*done.presses, shown),
        stages=tuple(work.stages),
    )


def _seen(
    done: Calibration, law: ForceLaw, held: Held, fitted: RecordTarget | RecordsTarget, x0: float
) -> Array:
    """Return the force (n_t,) N that the rig would record."""
    rig = presses(fitted)[0].rig.at({each.name: each.value for each in done.parameters})
    depth = held.position - x0 - rig["compliance"] * held.force
    model = lagged(held.time, law.predicted(held.time, depth), 1e-3 * rig["lag"])
    return np.interp(held.time - 1e-3 * rig["delay"], held.time, model)


def _law(done: Calibration, work: Work, held: Held) -> ForceLaw:
    """Return the force law of the fitted finger under another object, by a press on its mesh."""
    finger = fitted_finger(done, work.finger)
    # Depth of the press by another object over the largest depth of its record, from where the
    # force first shows: touch is a little before.
    deeper = 1.1
    deep = deeper * (float(held.position.max()) - held.shows)
    with work.stage("press of the record that was not fitted"):
        pressed = press(finger, done.mechanics, deep / finger.thickness, indenter=held.indenter)
    return ForceLaw(curve(pressed)[0], done.prony)


def fitted_finger(done: Calibration, finger: Finger) -> Finger:
    """Return the finger with the size and the tissue of a calibration."""
    skin, pulp = Tissue(**done.skin), Tissue(**done.subcutaneous)
    radius = done.finger["pad_radius"]
    return replace(finger, pad_radius=radius, skin=skin, subcutaneous=pulp)


def _touch(
    done: Calibration, law: ForceLaw, held: Held, fitted: RecordTarget | RecordsTarget
) -> float:
    """Return the position in mm of first touch with which a record is predicted best."""
    from scipy.optimize import minimize_scalar

    def off(x0: float) -> float:
        return float(np.sum((_seen(done, law, held, fitted, x0) - held.force) ** 2))

    earlier = 0.5  # travel in mm before the force shows, within which touch is sought
    bounds = (held.shows - earlier, held.shows)
    return float(minimize_scalar(off, bounds=bounds, method="bounded").x)
