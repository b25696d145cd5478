"""The page of `fefinger live` and its WebSocket, on the loopback address.

Nobody but the browser that was told the address can read the page or talk to the finger: the
address has a random token, and requests with the Host or the Origin of another site are refused.
"""

import asyncio
import hmac
import json
import secrets
import socket
import webbrowser
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path

from aiohttp import WSCloseCode, WSMsgType, web

from fefinger.live.player import MODULI, OBJECTS, PRESETS, SIZES, STEEPEST, UNITS, Setup, subjects
from fefinger.live.session import LONGEST, Session
from fefinger.mechanics.loop_setup import MECHANICS
from fefinger.pages import page
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES
from fefinger.view import figures


LOOPBACK = "127.0.0.1"

NAMES = (LOOPBACK, "localhost")
"""Names of this machine that a Host may have."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Server:
    """Serves the page to one tab at a time.

    Attributes
    ----------
    address
        Of the page, with its token.
    """

    def __init__(
        self, *, resolution: str, output: Path | None, setup: Setup, port: int = 0
    ) -> None:
        self._resolution, self._output, self._setup = resolution, output, setup
        self._token = secrets.token_urlsafe(24)
        self._session: Session | None = None
        try:
            self._socket = socket.create_server((LOOPBACK, port))
        except OSError as error:
            raise InputError(
                f"--port: expected a free port, received {port} ({error.strerror}); take another, "
                "or leave it out"
            ) from error
        self._port = self._socket.getsockname()[1]
        self.address = f"http://{LOOPBACK}:{self._port}/{self._token}/"

    async def serve(self, *, browser: bool, ready: Callable[[], None] = lambda: None) -> None:
        """Serve until cancelled; `browser`: open the page; `ready` is called before."""
        application = web.Application(middlewares=[self._guard])
        application.router.add_get("/{token}/", self._page)
        application.router.add_get("/{token}/socket", self._talk)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            await web.SockSite(runner, self._socket).start()
            ready()
            if browser:
                await asyncio.to_thread(webbrowser.open, self.address)
            await asyncio.Event().wait()
        finally:
            await runner.cleanup()

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse requests under another name of this machine, or with another token."""
        if request.host not in [f"{name}:{self._port}" for name in NAMES]:
            raise web.HTTPForbidden(text="Expected the address that fefinger printed.")
        token = request.match_info.get("token", "")
        if not hmac.compare_digest(token.encode(), self._token.encode()):
            raise web.HTTPNotFound(text="Expected the address that fefinger printed.")
        return await handler(request)

    async def _page(self, request: web.Request) -> web.Response:
        nonce = secrets.token_urlsafe(16)
        policy = {
            "default-src": "'none'",
            "script-src": f"'nonce-{nonce}'",
            "style-src": "'unsafe-inline'",
            "img-src": "data:",
            "connect-src": "'self'",
            "base-uri": "'none'",
            "form-action": "'none'",
            "frame-ancestors": "'none'",
        }
        headers = {
            "Content-Security-Policy": "; ".join(f"{key} {rule}" for key, rule in policy.items()),
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }
        text = rendered(nonce, self._setup)
        return web.Response(text=text, content_type="text/html", headers=headers)

    async def _talk(self, request: web.Request) -> web.WebSocketResponse:
        """Run a session with the page; a second tab is refused."""
        if request.headers.get("Origin") != f"http://{request.host}":
            raise web.HTTPForbidden(text="Expected the page of fefinger itself.")
        talk = web.WebSocketResponse(max_msg_size=4 * LONGEST, heartbeat=20.0)
        await talk.prepare(request)
        if self._session is not None:
            text = "The finger is in use in another tab; close that one, and load this page again."
            await talk.send_str(json.dumps({"kind": "refused", "text": text}))
            await talk.close(code=WSCloseCode.TRY_AGAIN_LATER)
            return talk
        outbox: asyncio.Queue[str | bytes] = asyncio.Queue()
        loop = asyncio.get_running_loop()

        def send(data: str | bytes) -> None:
            with suppress(RuntimeError):  # the loop has ended, and the session is about to
                loop.call_soon_threadsafe(outbox.put_nowait, data)

        session = Session(send, self._resolution, self._output, self._setup)
        self._session = session
        session.start()
        writing = asyncio.create_task(_write(talk, outbox))
        try:
            async for message in talk:
                if message.type is not WSMsgType.TEXT:
                    await talk.close(code=WSCloseCode.UNSUPPORTED_DATA)
                    break
                session.hear(message.data)
        finally:
            session.leave()
            writing.cancel()
            self._session = None
        return talk


async def _write(talk: web.WebSocketResponse, outbox: asyncio.Queue[str | bytes]) -> None:
    """Send what the session says, as long as the page reads it."""
    with suppress(ConnectionError):
        # Largest number of messages that wait for the page; one that is slower than that is left.
        waiting = 60
        while True:
            data = await outbox.get()
            if outbox.qsize() > waiting:
                await talk.close(code=WSCloseCode.TRY_AGAIN_LATER)
                return
            await (talk.send_str(data) if isinstance(data, str) else talk.send_bytes(data))


def rendered(nonce: str, setup: Setup) -> str:
    """Return the page, whose scripts have a nonce."""
    data = {
        "setup": setup.to_dict(),
        "colors": {kind: figures.COLORS[kind] for kind in TYPES},
    }
    return page.render(
        "live.html",
        title="fefinger live",
        nonce=nonce,
        subjects=subjects(),
        objects=OBJECTS,
        mechanics=MECHANICS,
        units=UNITS,
        presets=PRESETS,
        types=TYPES,
        sizes=SIZES,
        moduli=MODULI,
        steepest=STEEPEST,
        data=page.raw(json.dumps(data).replace("<", "\\u003c")),
        script=page.source("drawing.js") + page.source("live.js"),
    )
