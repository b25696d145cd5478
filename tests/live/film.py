"""Films the page for the documentation: `python tests/live/film.py docs/_static/live.webp`.

The clock of the session is slowed, so that every picture has the time that a browser without a
graphics card takes.
"""

import asyncio
import io
import sys
import time
from pathlib import Path

from browser import opened
from PIL import Image

from fefinger.live import session
from fefinger.live.player import Setup
from fefinger.live.server import Server


SLOWER, STEP, SIZE = 25.0, 0.08, (1180, 860)  # s of the model between pictures; pixels
SCRIPT = (  # s of the model, and what the page does then
    (0.1, "send({ kind: 'move', control: 'depth', value: 0.7 })"),
    (0.8, "send({ kind: 'move', control: 'depth', value: 1.4 })"),
    (1.8, "send({ kind: 'move', control: 'depth', value: -0.5 })"),
    (2.2, "send({ kind: 'play', name: '40 Hz' })"),
)
END = 3.8  # s


class Slow:
    """The clock of a session, slowed."""

    sleep = staticmethod(time.sleep)

    @staticmethod
    def perf_counter() -> float:
        """Return seconds that pass SLOWER times slower."""
        return time.perf_counter() / SLOWER


async def film(file: Path) -> None:
    """Play the script and write its pictures as an animated WebP file."""
    session.time = Slow  # type: ignore[assignment]  # a class in place of the module `time`
    server = Server(resolution="standard", output=None, setup=Setup())
    serving = asyncio.create_task(server.serve(browser=False))
    pictures, script = [], list(SCRIPT)
    async with opened(server.address, *SIZE) as tab:
        await tab.until("frame && frame.time > 0")
        while (now := await tab.value("frame.time")) < END:
            while script and now >= script[0][0]:
                await tab.value(script.pop(0)[1])
            await tab.picture(file.with_suffix(".png"), whole=False)
            with Image.open(io.BytesIO(file.with_suffix(".png").read_bytes())) as picture:
                pictures.append(picture.convert("RGB").resize((SIZE[0] * 3 // 4, SIZE[1] * 3 // 4)))
            await tab.until(f"frame.time >= {now + STEP}")
    serving.cancel()
    file.with_suffix(".png").unlink()
    first, *others = pictures
    how = {"duration": round(1e3 * STEP), "loop": 0, "quality": 60, "method": 4}
    first.save(file, save_all=True, append_images=others, **how)


if __name__ == "__main__":
    asyncio.run(film(Path(sys.argv[1])))
