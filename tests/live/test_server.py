"""Who may talk to the finger: wrong addresses, other sites, second tabs and wrong messages."""

import asyncio
import json
import sys
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress

import pytest
from refusals import refused


aiohttp = pytest.importorskip("aiohttp")  # before what imports it: the extra may be missing

from fefinger.commands.run import live  # noqa: E402
from fefinger.live import session  # noqa: E402
from fefinger.live.player import Player, Setup  # noqa: E402
from fefinger.live.server import Server  # noqa: E402
from fefinger.mechanics.loop import Loop  # noqa: E402
from fefinger.support.checks import InputError  # noqa: E402


@asynccontextmanager
async def served(**options: object) -> AsyncIterator[Server]:
    """Serve the page for as long as the block takes."""
    server = Server(resolution="coarse", **{"output": None, "setup": Setup()} | options)
    ready = asyncio.Event()
    serving = asyncio.create_task(server.serve(browser=False, ready=ready.set))
    await asyncio.wait_for(ready.wait(), 10)
    try:
        yield server
    finally:
        serving.cancel()
        with suppress(asyncio.CancelledError):
            await serving
        await asyncio.wait_for(_ended(), 30)


async def _ended() -> None:
    """Wait until no session steps the finger any more."""
    while any(each.name == session.THREAD for each in threading.enumerate()):
        await asyncio.sleep(0.01)


@pytest.fixture(autouse=True)
def _finger_at_hand(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give sessions the finger that is there."""
    monkeypatch.setattr(Setup, "loop", lambda setup, resolution, progress=None: loop)


def run(
    work: Callable[[Server, aiohttp.ClientSession], Awaitable[None]], **options: object
) -> None:
    """Run a client against a server of its own."""

    async def both() -> None:
        async with served(**options) as server, aiohttp.ClientSession() as client:
            await asyncio.wait_for(work(server, client), 60)

    asyncio.run(both())


def origin(server: Server) -> dict[str, str]:
    return {"Origin": server.address.rsplit("/", 2)[0]}


async def hear(talk: aiohttp.ClientWebSocketResponse, kind: str) -> dict[str, object]:
    """Return the next JSON message of a kind."""
    while True:
        message = await talk.receive()
        assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), message
        if message.type is aiohttp.WSMsgType.TEXT:
            said = json.loads(message.data)
            if said["kind"] == kind:
                return said


def test_the_page_stands_alone_and_is_small() -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        assert server.address.startswith("http://127.0.0.1:")
        async with client.get(server.address) as answer:
            text = await answer.text()
            assert answer.status == 200
            assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'")
            assert answer.headers["Referrer-Policy"] == "no-referrer"
        assert len(text) < 1.5e6
        assert "https://" not in text
        assert text.count("http://") == 0

    run(work)


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("", {"Host": "evil.example"}, 403),
        ("", {"Host": "evil.example:{port}"}, 403),
        ("../wrong-token/", {}, 404),
        ("..", {}, 404),
        ("socket", {"Origin": "http://evil.example"}, 403),
        ("socket", {"Origin": "null"}, 403),
        ("socket", {}, 403),
        ("../wrong-token/socket", {"Origin": "same"}, 404),
    ],
)
def test_strangers_are_refused(path: str, headers: dict[str, str], status: int) -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        site = server.address.rsplit("/", 2)[0]
        port = site.rsplit(":", 1)[1]
        given = {key: value.replace("{port}", port) for key, value in headers.items()}
        if given.get("Origin") == "same":
            given["Origin"] = site
        if "socket" in path:
            with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
                await client.ws_connect(server.address + path, headers=given)
            assert caught.value.status == status
            return
        async with client.get(server.address + path, headers=given) as answer:
            assert answer.status == status

    run(work)


def test_it_listens_on_the_loopback_address_alone() -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        assert server._socket.getsockname()[0] == "127.0.0.1"

    run(work)


def test_a_second_tab_is_refused_until_the_first_is_left() -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        where = server.address + "socket"
        first = await client.ws_connect(where, headers=origin(server))
        await hear(first, "shape")
        second = await client.ws_connect(where, headers=origin(server))
        said = await hear(second, "refused")
        assert "another tab" in said["text"]
        await first.close()
        await _ended()  # leaving frees it
        third = await client.ws_connect(where, headers=origin(server))
        await hear(third, "shape")
        await third.close()

    run(work)


def test_a_wrong_message_gets_a_sentence_and_the_finger_goes_on() -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        talk = await client.ws_connect(server.address + "socket", headers=origin(server))
        await hear(talk, "shape")
        await talk.send_str("{")
        assert "JSON object" in (await hear(talk, "error"))["text"]
        await talk.send_json({"kind": "save"})
        assert "-o DIR" in (await hear(talk, "error"))["text"]
        await talk.send_bytes(b"\0")  # no page sends bytes: the connection is closed
        data = aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY
        while (message := await talk.receive()).type in data:
            pass
        assert message.data == aiohttp.WSCloseCode.UNSUPPORTED_DATA

    run(work)


@pytest.mark.parametrize(
    ("text", "about"),
    [
        ("", "JSON"),
        ("[1]", "JSON"),
        ("[" * 1500, "JSON"),
        ("x" * 3000, "letters"),
        ('{"kind": "fly"}', "kind"),
        ('{"kind": ["move"]}', "kind"),
        ('{"kind": "move", "control": "depth"}', "value"),
        ('{"kind": "move", "control": "depth", "value": "1"}', "value"),
        ('{"kind": "move", "control": "depth", "value": NaN}', "value"),
        ('{"kind": "move", "control": "depth", "value": -1e300}', "value"),
        ('{"kind": "move", "control": "force", "value": -1}', "value"),
        ('{"kind": "move", "control": "speed", "value": 1}', "control"),
        ('{"kind": "save", "folder": "/etc"}', "folder"),
        ('{"kind": "pause", "on": 1}', "on"),
        ('{"kind": "play", "name": "300 Hz"}', "name"),
        ('{"kind": "choose", "setup": 3}', "setup"),
        ('{"kind": "choose", "setup": {"surface": "/etc/passwd"}}', "surface"),
        ('{"kind": "choose", "setup": {"subject": "../x"}}', "subject"),
        ('{"kind": "choose", "setup": {"size": 1e9}}', "size"),
        ('{"kind": "choose", "setup": {"angle": "a"}}', "angle"),
        ('{"kind": "choose", "setup": {"modulus": 0}}', "modulus"),
        ('{"kind": "choose", "setup": {"along": 1}}', "along"),
    ],
)
def test_messages_are_checked(text: str, about: str) -> None:
    with pytest.raises(InputError, match=about):
        session.parse(text)


def test_a_session_keeps_time_and_pauses(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(session.time, "perf_counter", lambda: clock[0])
    made = session.Clock()
    clock[0] = 0.05
    assert made.due() == pytest.approx(0.05)
    made.advance(0.05)
    clock[0] = 5.0  # the tab slept, or the machine is too slow
    assert made.due() == pytest.approx(session.BEHIND)
    assert made.lost == pytest.approx(4.95 - session.BEHIND)
    made.start()
    clock[0] = 5.01
    assert made.due() == pytest.approx(0.01)


def test_a_choice_that_cannot_be_prepared_leaves_the_finger(
    loop: Loop, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str | bytes] = []
    made = session.Session(said.append, "coarse", None, Setup())
    made._choose(Setup())
    before = made._player
    assert isinstance(before, Player)

    def refuse(setup: Setup, resolution: str, progress: object = None) -> Loop:
        raise InputError("object: expected another")

    monkeypatch.setattr(Setup, "loop", refuse)
    made._choose(Setup(kind="ball"))
    assert made._player is before
    last = json.loads(said[-1])
    assert last["text"] == "object: expected another"
    assert last["setup"]["kind"] == "plate"


def test_a_port_that_is_taken_is_named() -> None:
    async def work(server: Server, client: aiohttp.ClientSession) -> None:
        port = int(server.address.split(":")[2].split("/")[0])
        with refused("--port"):
            Server(resolution="coarse", output=None, setup=Setup(), port=port)

    run(work)


def test_the_command_checks_its_options() -> None:
    for words in (["--port", "70000"], ["--subject", "x.y."], ["--resolution", "rough"]):
        with pytest.raises(InputError, match=words[0].removeprefix("--")):
            live.main(words, standalone_mode=False)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_ends_by_a_bug_tells_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(setup: Setup, resolution: str, progress: object = None) -> Loop:
        raise ZeroDivisionError("by hand")

    monkeypatch.setattr(Setup, "loop", fail)
    said: list[str | bytes] = []
    made = session.Session(said.append, "coarse", None, Setup())
    made.start()
    made.join(10)
    assert "ZeroDivisionError: by hand" in json.loads(said[-1])["text"]


def test_without_the_extra_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    monkeypatch.delitem(sys.modules, "fefinger.live.server")
    with pytest.raises(InputError, match=r"pip install 'fefinger\[live\]'"):
        live.main(["--no-browser"], standalone_mode=False)
