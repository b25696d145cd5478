"""A headless Chromium that a test drives by its DevTools protocol, over aiohttp's WebSocket."""

import asyncio
import base64
import json
import shutil
import subprocess
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp


CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)

FLAGS = (
    *("--headless=new", "--no-sandbox", "--remote-debugging-port=0", "--no-first-run"),
    *("--disable-extensions", "--disable-component-update", "--disable-background-networking"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-sync", "--mute-audio"),
    *("--disable-dev-shm-usage", "--autoplay-policy=no-user-gesture-required"),
)

PATIENCE = 300.0
"""Time in s after which what a test waits for counts as missing: code may be compiled first."""


class Tab:
    """A tab: what it was asked, and what its console said."""

    def __init__(self, talk: aiohttp.ClientWebSocketResponse) -> None:
        self._talk, self._number = talk, 0
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self.said: list[str] = []
        self.requested: list[str] = []

    async def listen(self) -> None:
        """Read what the browser says, until it is closed."""
        async for message in self._talk:
            said = json.loads(message.data)
            if "id" in said:
                self._answers.pop(said["id"]).set_result(said)
            elif said["method"] == "Runtime.consoleAPICalled":
                self.said.append(str([each.get("value") for each in said["params"]["args"]]))
            elif said["method"] == "Runtime.exceptionThrown":
                self.said.append(str(said["params"]["exceptionDetails"]))
            elif said["method"] == "Log.entryAdded":
                self.said.append(said["params"]["entry"]["text"])
            elif said["method"] == "Network.requestWillBeSent":
                self.requested.append(said["params"]["request"]["url"])

    async def ask(self, method: str, **values: Any) -> dict[str, Any]:
        """Call a method of the protocol and return its result."""
        self._number += 1
        answer = asyncio.get_running_loop().create_future()
        self._answers[self._number] = answer
        await self._talk.send_json({"id": self._number, "method": method, "params": values})
        said = await asyncio.wait_for(answer, PATIENCE)
        assert "error" not in said, said
        result: dict[str, Any] = said["result"]
        return result

    async def value(self, script: str) -> Any:
        """Return the value of an expression in the page."""
        said = await self.ask("Runtime.evaluate", expression=script, returnByValue=True)
        assert "exceptionDetails" not in said, said
        return said["result"].get("value")

    async def until(self, script: str) -> Any:
        """Wait until an expression is true, and return it."""

        async def look() -> Any:
            while not (found := await self.value(script)):
                await asyncio.sleep(0.05)
            return found

        try:
            return await asyncio.wait_for(look(), PATIENCE)
        except TimeoutError:
            status = await self.value("document.body.innerText.slice(-300)")
            raise AssertionError(f"never: {script}; status: {status}; said: {self.said}") from None

    async def mouse(self, kind: str, x: float, y: float, **values: Any) -> None:
        """Send an event of the mouse at a place in pixels."""
        await self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **values)

    async def middle(self, selector: str) -> tuple[float, float]:
        """Scroll an element into view and return its middle in pixels."""
        script = (
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            " e.scrollIntoView({block: 'center'}); const r = e.getBoundingClientRect();"
            " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )
        x, y = await self.value(script)
        return x, y

    async def drag(self, selector: str, down: float) -> None:
        """Drag from the middle of an element by some pixels down."""
        x, y = await self.middle(selector)
        await self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        for k in range(1, 6):
            await self.mouse("mouseMoved", x, y + down * k / 5, button="left", buttons=1)
        await self.mouse("mouseReleased", x, y + down, button="left", clickCount=1)

    async def click(self, selector: str) -> None:
        """Click on an element."""
        x, y = await self.middle(selector)
        for kind in ("mousePressed", "mouseReleased"):
            await self.mouse(kind, x, y, button="left", buttons=1, clickCount=1)

    async def key(self, key: str, code: int) -> None:
        """Press a key."""
        for kind in ("rawKeyDown", "keyUp"):
            await self.ask(
                "Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code
            )

    async def picture(self, path: Path, *, whole: bool = True) -> None:
        """Write a picture of the page, or of what is seen of it, to a PNG file."""
        said = await self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(said["data"]))


@asynccontextmanager
async def opened(address: str, width: int = 1400, height: int = 1000) -> AsyncIterator[Tab]:
    """Open a page in a browser of its own, whose tab is closed at the end."""
    assert CHROMIUM is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        words = [CHROMIUM, *FLAGS, f"--user-data-dir={folder}", f"--window-size={width},{height}"]
        process = subprocess.Popen(
            [*words, "about:blank"], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL
        )
        try:
            async with aiohttp.ClientSession() as session:
                port = await _port(Path(folder) / "DevToolsActivePort")
                async with session.get(f"http://127.0.0.1:{port}/json") as answer:
                    tabs = [each for each in await answer.json() if each["type"] == "page"]
                talk = await session.ws_connect(tabs[0]["webSocketDebuggerUrl"], max_msg_size=0)
                tab = Tab(talk)
                listening = asyncio.create_task(tab.listen())
                for domain in ("Page", "Runtime", "Log", "Network"):
                    await tab.ask(f"{domain}.enable")
                size = {"width": width, "height": height, "deviceScaleFactor": 1}
                await tab.ask("Emulation.setDeviceMetricsOverride", mobile=width < 500, **size)
                await tab.ask("Page.navigate", url=address)
                await tab.until(
                    "location.protocol !== 'about:' && document.readyState === 'complete'"
                )
                yield tab
                listening.cancel()
                await talk.close()
        finally:
            process.terminate()
            process.wait()


async def _port(file: Path) -> int:
    """Return the port that the browser writes into its folder."""

    async def look() -> int:
        while not (file.exists() and "\n" in file.read_text()):
            await asyncio.sleep(0.05)
        return int(file.read_text().split()[0])

    return await asyncio.wait_for(look(), PATIENCE)
