"""The page in a real browser: pressed by mouse, keys and on a phone; what is saved runs again."""

import asyncio
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest


pytest.importorskip("aiohttp")

from browser import CHROMIUM, Tab, opened

from fefinger.live.player import Setup
from fefinger.live.server import Server
from fefinger.result import load
from fefinger.scene.scene import Scene


pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium is at hand, in which the page is tested"
)

READY = "frame && frame.time > 0"
PHONE = 390  # px
HIDDEN = (
    "Object.defineProperty(document, 'hidden', {{ value: {}, configurable: true }});"
    "document.dispatchEvent(new Event('visibilitychange'))"
)


def shown(work: Callable[[Tab, Server], Coroutine[Any, Any, None]], output: Path) -> None:
    """Run a test in a browser that shows a page of its own; nothing may be on its console."""

    async def both() -> None:
        server = Server(resolution="coarse", output=output, setup=Setup())
        serving = asyncio.create_task(server.serve(browser=False))
        async with opened(server.address) as tab:
            await tab.until(READY)
            await work(tab, server)
            assert tab.said == []
            assert {url.split("/")[2] for url in tab.requested} == {server.address.split("/")[2]}
        serving.cancel()

    asyncio.run(both())


def test_it_is_pressed_by_mouse_and_keys_and_what_is_saved_is_repeated(tmp_path: Path) -> None:
    async def work(tab: Tab, server: Server) -> None:
        assert await tab.value("frame.force") == 0.0  # exact: no contact
        await tab.click("#record")
        await tab.until("frame.recording")
        await tab.click(".sound[value=SAI]")
        await tab.drag("#section", -60)
        await tab.until("frame.force > 0.05 && spikes.length > 0")
        assert await tab.value("Math.max(...frame.pressure)") > 1.0
        assert await tab.value("Math.max(...frame.strain)") > 5.0
        await tab.value("element('section').focus()")
        await tab.until("Math.abs(frame.depth - aimed.value) < 0.001")  # it moves no deeper
        before = await tab.value("frame.depth")
        await tab.key("ArrowDown", 40)
        await tab.until(f"frame.depth < {before} - 0.01")
        await tab.key("Escape", 27)
        await tab.until("frame.force === 0")
        await tab.click("#record")
        await tab.until("!frame.recording")
        await tab.click("#save")
        await tab.until("element('status').textContent.startsWith('Saved')")
        played = await tab.value("last.peak")
        again = await tab.value("last.run_peak")
        assert again == pytest.approx(played, rel=0.02)
        result = load(tmp_path / "play-1")
        scene = Scene.from_toml(tmp_path / "play-1" / "scene.toml")
        assert result.force is not None
        assert result.force.max() == pytest.approx(played, rel=0.02)
        assert result.scene == scene  # exact: what is written is read
        assert (tmp_path / "play-1" / "spikes.csv").stat().st_size > 50
        assert [path.name for path in tmp_path.iterdir()] == ["play-1"]

    shown(work, tmp_path)


def test_pictures_are_coarser_while_drawing_is_slow_and_fine_again_at_rest(tmp_path: Path) -> None:
    async def work(tab: Tab, server: Server) -> None:
        twice = "for (let k = 0; k < 2; k++) { drawn = null; draw(); }"  # one picture at a time

        def frames(taken: float) -> str:
            return f"for (let k = 0; k < 100; k++) pace.note({taken});" + twice

        pixels = "scenes.map(({{ canvas }}) => Math.round({} * canvas.clientWidth))"
        width = "scenes.map(({ canvas }) => canvas.width)"

        async def after(script: str, number: float) -> None:
            widths, wanted = await tab.value(f"{script} [{width}, {pixels.format(number)}]")
            assert widths == wanted

        await tab.value(
            "delete scenes[0].organs; scenes[0].write()"
        )  # words before a first picture
        await after(frames(100), 0.5)
        await after("pace.patience = 1;" + frames(5), 2)
        await after(frames(100), 0.5)
        await tab.until("still")
        await after("", 2)
        await after("pace.note = () => {};" + twice, 0.5)

    shown(work, tmp_path)


def test_another_object_is_pressed_on_a_phone_and_a_hidden_tab_pauses(tmp_path: Path) -> None:
    async def work(tab: Tab, server: Server) -> None:
        size = {"width": PHONE, "height": 844, "deviceScaleFactor": 1, "mobile": True}
        await tab.ask("Emulation.setDeviceMetricsOverride", **size)
        assert await tab.value("document.documentElement.scrollWidth") <= PHONE
        await tab.value("form.elements.kind.value = 'ball'; adapt()")
        await tab.click("#setup button")
        await tab.until(f"shape.setup.kind === 'ball' && {READY}")
        await tab.ask("Emulation.setTouchEmulationEnabled", enabled=True)
        x, y = await tab.middle("#section")
        for kind, points in (
            ("touchStart", [(x, y)]),
            ("touchMove", [(x, y - 40)]),
            ("touchEnd", []),
        ):
            touches = [{"x": a, "y": b} for a, b in points]
            await tab.ask("Input.dispatchTouchEvent", type=kind, touchPoints=touches)
        await tab.until("frame.force > 0")
        await tab.value(HIDDEN.format("true"))
        paused = -1.0
        while paused != (paused := await tab.value("frame.time")):  # exact: the same frame
            await asyncio.sleep(0.5)
        await tab.value(HIDDEN.format("false"))
        await tab.until(f"frame.time > {paused}")

    shown(work, tmp_path)
