"""End commands by signals at random times, and see what they leave: `python tests/interrupts.py`.

Every draw starts a command in a folder of its own, sends SIGINT (or SIGTERM, one in four) after a
random time, and requires: status 0, 130 or 143; one sentence on standard error; nothing under a
final name unless the command was done; no temporary file and no process left. Linux only (/proc).
"""

import argparse
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path


SENTENCES = {
    130: "interrupted; nothing was left half-written\n",
    143: "terminated; nothing was left half-written\n",
}
GOES_ON = "; the same command continues from the finished scenes\n"
PATIENCE = 60.0  # s that an ended command may take at the most
GRACE = 1.0  # s after which no process of an ended command may be left


@dataclass(frozen=True)
class Command:
    """A command line, how long it takes in s, and what it needs.

    needs: files that an earlier run made for it; record: the text of record.csv.
    """

    words: tuple[str, ...]
    seconds: float
    needs: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()  # final names that may be there: what is finished bit by bit
    record: str = ""


def record() -> str:
    """Return the record of a press to 1.5 mm in 0.3 s and a hold, of a finger that relaxes."""
    lines = ["time,position,force"]
    for k in range(101):
        time, depth = 0.01 * k, min(0.05 * k, 1.5)
        left = 0.7 + 0.3 * math.exp(-max(time - 0.3, 0.0) / 0.2)
        lines.append(f"{time:.2f},{depth:.3f},{0.2 * left * (math.exp(1.3 * depth) - 1.0):.4f}")
    return "\n".join(lines) + "\n"


PRESS = ("--set", "finger.resolution=coarse", "--set", "motion.hold=0.2")
COMMANDS = {
    "run": Command(("run", "sphere-press", "-o", "out", *PRESS), 12.0),
    "mesh": Command(
        ("mesh", "flat-press", "--set", "finger.thickness=11.3", "-o", "out.vtu"), 12.0
    ),
    "study": Command(
        (
            *("study", "flat-press", "--over", "indenter.angle=20:40:8", "--workers", "2"),
            *("--mechanics", "linear", *PRESS, "-o", "out"),
        ),
        20.0,
        kept=("out/scenes/*.json", "out/mechanics.json"),
    ),
    "calibrate": Command(
        ("calibrate", "record.csv", "--subject", "a.h.", "--resolution", "coarse", "-o", "out"),
        20.0,
        record=record(),
    ),
    "validate": Command(("validate", "fem", "--quick", "-o", "out"), 15.0),
    "view": Command(("view", "made", "--screenshot", "out.png"), 4.0, needs=("made",)),
}


@dataclass(frozen=True)
class Outcome:
    """What became of a draw: the exit status, and what is wrong with it ("" if nothing)."""

    command: str
    signal: str
    after: float
    status: int
    took: float
    wrong: str


def stop_ignoring() -> None:
    """Let child processes take the signals, also where a script runs this one in the background."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def draw(name: str, after: float, number: signal.Signals, made: Path | None = None) -> Outcome:
    """Run a command, send it a signal `after` seconds, and judge what is left.

    `made`: a folder in which the files that commands need were made by an earlier run.
    """
    stop_ignoring()
    command = COMMANDS[name]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, "work")
        place.mkdir()
        for need in command.needs:
            assert made is not None
            shutil.copytree(made / need, place / need)
        if command.record:
            (place / "record.csv").write_text(command.record, encoding="ascii")
        before = {path.relative_to(place) for path in place.rglob("*")}
        for other in ("temporary", "cache"):
            Path(folder, other).mkdir()
        mark = f"FEFINGER_DRAW={os.getpid()}-{random.getrandbits(64):x}"
        key, value = mark.split("=")
        process = subprocess.Popen(
            [sys.executable, "-m", "fefinger", *command.words],
            cwd=place,
            env={
                **os.environ,
                **{"TMPDIR": f"{folder}/temporary", "XDG_CACHE_HOME": f"{folder}/cache"},
                key: value,
            },
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        _wait_until_it_blocks(process)
        try:
            process.wait(after)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
        sent = time.monotonic()
        _, text = process.communicate(timeout=PATIENCE)
        took = time.monotonic() - sent
        left = _processes_left(mark)
        found = {path.relative_to(place) for path in place.rglob("*")} - before
        wrong = _judged(command, process.returncode, text, found, Path(folder), left)
    return Outcome(name, number.name, after, process.returncode, took, wrong)


def _wait_until_it_blocks(process: "subprocess.Popen[str]") -> None:
    """Wait until Python has started and the command line takes signals by itself."""
    bit = 1 << (signal.SIGINT - 1)
    while process.poll() is None:
        status = Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
        masks = dict(line.split(":\t") for line in status.splitlines() if ":\t" in line)
        if int(masks["SigBlk"], 16) & bit:
            return
        time.sleep(1e-3)


def _processes_left(mark: str) -> list[str]:
    """Return the processes that still have the mark in their environment after GRACE."""
    end = time.monotonic() + GRACE
    while True:
        left = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            try:
                if mark.encode() in path.read_bytes().split(b"\0"):
                    left.append(path.parent.joinpath("cmdline").read_text()[:80])
            except OSError:  # gone, or of another user
                continue
        if not left or time.monotonic() > end:
            return left
        time.sleep(0.02)


def _judged(
    command: Command, status: int, text: str, found: set[Path], folder: Path, left: list[str]
) -> str:
    wrong = []
    if status not in (0, *SENTENCES):
        wrong.append(f"status {status}")
    if status in SENTENCES:
        first = SENTENCES[status].partition(";")[0]
        if text not in (SENTENCES[status], first + GOES_ON):
            wrong.append(f"standard error {text!r}")
        finished = {path for pattern in command.kept for path in folder.glob(f"work/{pattern}")}
        files = {path for path in found if (folder / "work" / path).is_file()}
        more = files - {path.relative_to(folder / "work") for path in finished}
        if more or (found and not finished):
            wrong.append(f"files {sorted(map(str, more or found))}")
    stray = [path for path in folder.glob("temporary/*") if not path.name.startswith("numba-")]
    stray += [path for path in folder.rglob(".*") if path.name.startswith((".building", ".saving"))]
    if stray:
        wrong.append(f"temporary files {[path.name for path in stray]}")
    if left:
        wrong.append(f"processes {left}")
    return "; ".join(wrong)


def make(folder: Path) -> Path:
    """Run what the commands need once, and return its folder."""
    words = ("run", "flat-press", "-o", str(folder / "made"), *PRESS)
    subprocess.run([sys.executable, "-m", "fefinger", *words], check=True, capture_output=True)
    return folder


def main() -> int:
    """Draw, print every failure and a histogram, and return 1 if there was one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    drawn = random.Random(given.seed)
    counts: Counter[tuple[str, str, str]] = Counter()
    slowest, failed = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        made = make(Path(folder))
        for number in range(given.draws):
            name = list(COMMANDS)[number % len(COMMANDS)]
            after = drawn.uniform(0, COMMANDS[name].seconds)
            sent = signal.SIGTERM if drawn.random() < 0.25 else signal.SIGINT
            outcome = draw(name, after, sent, made)
            counts[name, sent.name, str(outcome.status)] += 1
            slowest = max(slowest, outcome.took if outcome.status else 0.0)
            if outcome.wrong:
                failed += 1
                print(outcome, flush=True)
    for (name, sent, status), count in sorted(counts.items()):
        print(f"{name:10} {sent:8} status {status:4} {count:4}")
    print(f"{given.draws} draws, {failed} wrong, the slowest end after {slowest:.2f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
