"""A session of the page: a thread that steps a player against the clock, and answers messages.

What the page may send: JSON objects with a `kind`, checked as any other input.
"""

import json
import queue
import struct
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fefinger.live.picture import Picture
from fefinger.live.player import ABOVE, PRESETS, Player, Setup
from fefinger.pipeline import run
from fefinger.support.atomic_write import in_place, output_folder
from fefinger.support.checks import (
    ConvergenceError,
    InputError,
    boolean,
    choice,
    number,
    reject_unknown,
)
from fefinger.support.vocabulary import Control


LONGEST = 2000
"""Largest number of letters of a message."""


@dataclass(frozen=True)
class Choose:
    """Prepare the finger and the object of a choice."""

    setup: Setup


@dataclass(frozen=True)
class Move:
    """Move the object to a depth in mm or a force in N."""

    control: Control
    value: float


@dataclass(frozen=True)
class Play:
    """Play a preset."""

    name: str


@dataclass(frozen=True)
class Pause:
    """Stop the clock, or let it go on."""

    on: bool


@dataclass(frozen=True)
class Record:
    """Begin a record, or end it."""

    on: bool


@dataclass(frozen=True)
class Save:
    """Save the record."""


@dataclass(frozen=True)
class Drawn:
    """A frame was drawn; the next may follow."""


Message = Choose | Move | Play | Pause | Record | Save | Drawn

KEYS = {
    "choose": ("setup",),
    "move": ("control", "value"),
    "play": ("name",),
    "pause": ("on",),
    "record": ("on",),
    "save": (),
    "drawn": (),
}
"""Keys of the messages by their kind, all of them needed."""


def parse(text: str) -> Message:
    """Return a message of the page; InputError for anything else."""
    if len(text) > LONGEST:
        size = f"{len(text)} letters"
        raise InputError(f"message: expected at most {LONGEST} letters, received {size}")
    try:
        table = json.loads(text)
    except (ValueError, RecursionError):
        table = None
    if not isinstance(table, dict):
        raise InputError(f"message: expected a JSON object, received {text[:40]!r}")
    kind = choice("message.kind", table.pop("kind", None), KEYS)
    reject_unknown("message", table, KEYS[kind])
    for key in KEYS[kind]:
        if key not in table:
            raise InputError(f"message.{key}: missing; a message {kind!r} needs it")
    return _read(kind, table)


def _read(kind: str, table: dict[str, object]) -> Message:
    """Return a message from a table with the keys of its kind."""
    if kind == "choose":
        given = table["setup"]
        if not isinstance(given, dict):
            raise InputError(f"message.setup: expected a table, received {given!r}")
        return Choose(Setup.of(given))
    if kind == "move":
        control = Control(choice("message.control", table["control"], tuple(Control)))
        least, unit = control.of(ABOVE, 0.0), control.unit
        return Move(control, number("message.value", table["value"], at_least=least, unit=unit))
    if kind == "play":
        return Play(choice("message.name", table["name"], PRESETS))
    if kind in ("pause", "record"):
        on = boolean("message.on", table["on"])
        return Pause(on) if kind == "pause" else Record(on)
    return Save() if kind == "save" else Drawn()


BEHIND = 0.1
"""Time in s that the model may be behind the clock to catch up; what is more is lost."""

THREAD = "fefinger live"

Send = Callable[[str | bytes], None]


class Left(Exception):
    """The page was left while the finger was prepared."""


class Clock:
    """The clock that the model follows: how much of the model is due, and what was lost."""

    def __init__(self) -> None:
        self.lost, self.pace = 0.0, 1.0
        self.start()

    def start(self) -> None:
        """Begin, or go on after a pause."""
        self._origin, self._done = time.perf_counter(), 0.0
        self._since, self._at = self._origin, 0.0

    def due(self) -> float:
        """Return the time in s that the model is behind; what is beyond BEHIND counts as lost."""
        now = time.perf_counter()
        behind = now - self._origin - self._done
        if behind > BEHIND:
            self.lost += behind - BEHIND
            self._origin += behind - BEHIND
            behind = BEHIND
        rating = 1.0  # time in s over which the pace of the model is measured
        if now - self._since > rating:
            self.pace = (self._done - self._at) / (now - self._since)
            self._since, self._at = now, self._done
        return behind

    def advance(self, seconds: float) -> None:
        """Note that the model has advanced."""
        self._done += seconds


class Session(threading.Thread):
    """A finger that one page plays with, in a thread of its own.

    Parameters
    ----------
    send
        Called with what the page is to receive: a JSON text or the bytes of a frame.
    resolution
        Mesh of the finger.
    output
        Folder that records are saved to; None refuses to save.
    setup
        The first choice.
    """

    def __init__(self, send: Send, resolution: str, output: Path | None, setup: Setup) -> None:
        super().__init__(name=THREAD, daemon=True)
        self._send, self._resolution, self._output = send, resolution, output
        self._inbox: queue.SimpleQueue[Message | None] = queue.SimpleQueue()
        self._inbox.put(Choose(setup))
        self._left = threading.Event()
        self._player: Player | None = None
        self._picture: Picture | None = None
        self._clock, self._paused, self._drawn, self._shown = Clock(), False, True, 0.0

    def hear(self, text: str) -> None:
        """Take a message of the page; a wrong one is answered by a sentence."""
        try:
            self._inbox.put(parse(text))
        except InputError as error:
            self._tell("error", text=str(error))

    def leave(self) -> None:
        """End the session; its thread ends after the step, or stage, that it is at."""
        self._left.set()
        self._inbox.put(None)

    def run(self) -> None:
        """Step and answer until the page is left."""
        try:
            while not self._left.is_set():
                idle = self._player is None or self._paused
                self._answer_all(wait=None if idle else 0.0)
                if self._player is not None and not self._paused:
                    self._advance(self._player)
        except Left:
            pass
        except Exception as error:  # a bug: the thread ends, and the page has to know
            self._tell("error", text=f"The finger has stopped: {type(error).__name__}: {error}")
            raise
        finally:
            self._player = self._picture = None

    def _advance(self, player: Player) -> None:
        """Do what is due: steps, and a frame."""
        due, done = self._clock.due(), 0
        batch = 20  # most steps between two looks at the messages
        try:
            while due >= player.dt and done < batch:
                due -= player.dt
                done += 1
                self._clock.advance(player.dt)
                player.step()
        except (InputError, ConvergenceError) as error:
            self._tell("error", text=str(error))
        now = time.perf_counter()
        frame = 1 / 60  # least time in s between two frames
        if self._drawn and now - self._shown >= frame:
            self._drawn, self._shown = False, now
            self._send(self._frame(player))
        elif done < batch:
            nap = 2e-3  # time in s to wait where nothing is due
            time.sleep(nap)

    def _answer_all(self, wait: float | None) -> None:
        """Answer the messages that are there; wait for one if nothing else is to do."""
        try:
            while True:
                message = self._inbox.get(block=wait is None)
                if self._left.is_set() or message is None:
                    raise Left
                wait = 0.0
                self._answer(message)
        except queue.Empty:
            return

    def _answer(self, message: Message) -> None:
        """Answer a message; errors are told, and the finger stays as it was."""
        try:
            if isinstance(message, Choose):
                self._choose(message.setup)
            elif isinstance(message, Drawn):
                self._drawn = True
            elif isinstance(message, Pause):
                self._paused = message.on
                self._clock.start()
            elif self._player is not None:
                self._act(self._player, message)
        except (InputError, ConvergenceError) as error:
            self._tell("error", text=str(error))

    def _act(self, player: Player, message: Message) -> None:
        """Do what a message asks of the finger."""
        if isinstance(message, Move):
            player.move(message.control, message.value)
        elif isinstance(message, Play):
            player.play(message.name)
        elif isinstance(message, Record):
            if message.on:
                player.record()
            player.recording = message.on
        elif isinstance(message, Save):
            self._save(player)

    def _choose(self, setup: Setup) -> None:
        """Prepare the finger of a choice, and show it."""
        try:
            with warnings.catch_warnings(record=True) as noted:
                warnings.simplefilter("always")
                loop = setup.loop(self._resolution, self._report)
            self._report("picture", 0.0)
            picture, player = Picture(loop), Player(setup, loop)
            shape = picture.shape()
        except (InputError, ConvergenceError) as error:
            self._tell("error", text=str(error), setup=self._setup)
            return
        finally:
            self._clock.start()
        self._picture, self._player, self._drawn, self._clock = picture, player, True, Clock()
        self._tell(
            "shape",
            setup=setup.to_dict(),
            finger=repr(loop),
            notes=[str(each.message) for each in noted],
            most={str(control): most for control, most in player.most.items()},
            types=list(player.units.types),
            saves=self._output is not None,
            **shape.table,
        )
        self._send(shape.arrays)

    @property
    def _setup(self) -> dict[str, object] | None:
        """The present choice."""
        return None if self._player is None else self._player.setup.to_dict()

    def _report(self, stage: str, fraction: float) -> None:
        """Tell the progress of a preparation or of a run, unless the page was left."""
        if self._left.is_set():
            raise Left
        self._tell("progress", stage=stage, fraction=fraction)

    def _frame(self, player: Player) -> bytes:
        """Return a frame: a JSON text and arrays of floats, after the lengths of text and trace."""
        assert self._picture is not None
        heard, now = player.heard(), player.loop.now
        state = {
            "time": player.time,
            "depth": now.depth,
            "force": now.force,
            "area": now.contact_area,
            "control": str(player.control),
            "value": player.value,
            "playing": player.playing,
            "recording": player.recording,
            "recorded": 0.0 if player.take is None else player.take.seconds,
            "pace": self._clock.pace,
            "lost": self._clock.lost,
            "spikes": heard.spikes,
        }
        text = json.dumps(state).encode()
        text += b" " * (-len(text) % 4)
        lengths = struct.pack("<II", len(text), heard.trace.size)
        trace = heard.trace.astype("<f4").tobytes()
        return lengths + text + trace + self._picture.frame()

    def _save(self, player: Player) -> None:
        """Save the record as a scene, and run the scene and save its result beside it."""
        if self._output is None:
            raise InputError(
                "record: expected a folder to save to, received none; start `fefinger live` "
                "with -o DIR"
            )
        if player.take is None:
            raise InputError("record: expected a record, received none; record a touch first")
        player.recording = False
        folder = free_folder(self._output)
        scene = player.take.scene(folder.name, self._resolution)
        result = run(scene, progress=self._report)
        files = result.save(output_folder(folder))
        with in_place(folder / "scene.toml") as new:
            new.write_text(scene.to_toml(), encoding="utf-8")
        self._clock.start()
        peak = None if result.force is None else float(result.force.max())
        names = [*files, str(folder / "scene.toml")]
        self._tell("saved", files=names, peak=player.take.peak, run_peak=peak)

    def _tell(self, kind: str, **values: Any) -> None:
        """Send a JSON message."""
        self._send(json.dumps({"kind": kind, **values}))


def free_folder(output: Path) -> Path:
    """Return the first folder `play-1`, `play-2`, ... in the output that does not exist."""
    number = 1
    while (output / f"play-{number}").exists():
        number += 1
    return output / f"play-{number}"
