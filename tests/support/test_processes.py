"""Child processes: what they return, what becomes of one that dies, and when they end."""

import os
import pickle
import subprocess
import sys
from types import ModuleType

import process_calls
import pytest
from refusals import refused

from fefinger.support import processes


def test_every_item_has_its_value_whichever_process_it_came_from():
    numbers = [3.0, 1.0, 2.0, 5.0]
    assert dict(processes.each(process_calls.square, numbers, 2)) == {
        place: number**2 for place, number in enumerate(numbers)
    }


def test_the_work_is_done_in_processes_that_are_kept():
    (a, b) = (value for _, value in processes.each(process_calls.process, [None, None], 1))
    assert a == b != os.getpid()


def test_a_process_that_dies_costs_one_item_and_is_replaced():
    actual = dict(processes.each(process_calls.end_for_odd, [0, 1, 2], 1))
    assert actual[0] == actual[2] == {"rows": []}
    assert actual[1].status == 3


def test_an_exception_is_raised_here_and_ends_the_processes():
    with pytest.raises(ValueError, match=r"number [78]"):
        list(processes.each(process_calls.fail, [7.0, 8.0], 2))


def test_nothing_to_do_starts_nothing(monkeypatch):
    monkeypatch.delattr(processes, "Worker")
    assert list(processes.each(process_calls.square, [], 2)) == []


def test_a_call_in_the_background_has_its_value_or_its_error():
    with processes.in_background(process_calls.square, 3.0) as value:
        assert value() == 9.0
    with (
        processes.in_background(process_calls.fail, 3.0) as value,
        pytest.raises(ValueError, match=r"number 3"),
    ):
        value()
    with (
        processes.in_background(process_calls.end_for_odd, 1) as value,
        pytest.raises(processes.WorkerExit),
    ):
        value()


def test_a_call_that_the_child_cannot_import_is_an_error_here_and_the_next_one_is_answered(
    monkeypatch,
):
    here = ModuleType("only_here")
    exec("def call(item): return item", here.__dict__)
    monkeypatch.setitem(sys.modules, "only_here", here)
    worker = processes.Worker()
    try:
        worker.start(here.call, 1)
        with pytest.raises(ModuleNotFoundError, match="only_here"):
            worker.wait()
        worker.start(process_calls.square, 3.0)
        assert worker.wait() == pytest.approx(9.0)
    finally:
        worker.end()


def test_a_process_in_the_background_ends_with_the_block(monkeypatch):
    started = []

    class Kept(processes.Worker):
        def _started(self):
            started.append(super()._started())
            return started[-1]

    monkeypatch.setattr(processes, "Worker", Kept)
    with processes.in_background(process_calls.print_and_sleep, 600.0):
        assert started[0].poll() is None
    assert len(started) == 1
    assert started[0].poll() is not None


@pytest.mark.parametrize("limit", ["0", "-1", "two", "1.5"])
def test_a_limit_of_threads_that_is_no_number_is_named(monkeypatch, limit):
    monkeypatch.setenv(processes.THREADS, limit)
    with refused("NUMBA_NUM_THREADS"):
        processes.threads()


def test_prints_do_not_mix_with_the_answers(capfd):
    assert dict(processes.each(process_calls.print_and_sleep, [0.0], 1)) == {0: None}
    assert "a print" in capfd.readouterr().err


def test_a_worker_ends_in_its_work_when_nobody_asks_any_more():
    """However its parent ended; without a word."""
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    command, environment = processes.command("-c", processes.SERVE), processes.environment()
    with subprocess.Popen(command, env=environment, **pipes) as worker:
        pickle.dump(pickle.dumps((process_calls.print_and_sleep, 600.0)), worker.stdin)
        worker.stdin.flush()
        assert worker.stderr.readline() == b"a print\n"
        worker.stdin.close()
        assert worker.wait(timeout=20) == 143
        assert worker.stderr.read() == b""
