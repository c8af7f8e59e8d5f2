"""The dashboard in a browser: one bench, and a dashboard that attaches to it for each page that is opened.

textual-serve draws; what is here decides who may look. Every address begins with a random token, the page, what it
loads and its websocket alike; without it there is nothing but 403. A cookie would be sent to every other port of the
same host.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import secrets
import select
import shlex
import socket
import sys
from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import web
from textual_serve.server import Server

from hilbench.errors import UnavailableError
from hilbench.terminal import interruption
from hilbench.terminal.console import Console
from hilbench.tui.bench_process import BenchProcess, Phase

__all__ = ["WebDashboard", "serve_web"]

_TOKEN_BYTES = 24
_LOOK_EVERY_S = 0.05
_GOODBYE_S = 2.0
_LOOPBACK = frozenset({"127.0.0.1", "::1", "localhost"})
_EVERYWHERE = frozenset({"0.0.0.0", "::", ""})  # noqa: S104 - to tell that it is
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    # The page of textual-serve asks a foreign host for a font; a bench tells nobody that it is looked at.
    "Content-Security-Policy": "default-src 'self'; script-src 'self' 'unsafe-inline'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data:; font-src 'self' data:",
}

StartBench = Callable[[], BenchProcess]
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class WebDashboard(Server):
    """See the module.

    Args:
        start: starts the bench; again, when a page is opened after it has ended.
        token: what every address begins with.

    Attributes:
        process: the bench.

    Raises:
        UnavailableError: the bench does not begin.
    """

    def __init__(self, start: StartBench, token: str) -> None:
        self.process = _begun(start)
        super().__init__("", title=f"hilbench {self.process.about.get('bench', '')}".rstrip())
        self._start = start
        self._token = token
        self._pages: set[asyncio.Task[Any]] = set()

    async def make(self) -> web.Application:
        """Return what answers."""
        guarded = web.Application(middlewares=[self._guard])
        guarded.add_subapp(f"/{self._token}/", await self._make_app())
        guarded.on_response_prepare.append(_add_headers)
        return guarded

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        first = request.path.split("/")[1]
        if not secrets.compare_digest(first.encode("utf-8", "surrogateescape"), self._token.encode()):
            raise web.HTTPForbidden(text="403: this is not the address that 'hilbench --web' has printed\n")
        if request.path == f"/{self._token}":
            raise web.HTTPPermanentRedirect(f"{request.path}/")
        return await handler(request)

    async def on_startup(self, app: web.Application) -> None:
        """Say nothing: whoever serves has said where."""

    async def on_shutdown(self, app: web.Application) -> None:
        """End the dashboards of all pages."""
        del app
        for page in self._pages:
            page.cancel()
        if self._pages:
            await asyncio.wait(self._pages, timeout=_GOODBYE_S)

    async def handle_index(self, request: web.Request) -> Any:
        """Return the page, with addresses as the browser knows them: a port may be forwarded."""
        self.public_url = f"{request.scheme}://{request.host}"
        return await super().handle_index(request)

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """Run a dashboard for a page, on the bench, which is started anew if it has ended."""
        page = asyncio.current_task()
        assert page is not None
        self._pages.add(page)
        try:
            await asyncio.to_thread(self._revive)
            words = [sys.executable, "-m", "hilbench", "attach", self.process.session.name]
            self.command = f"exec {shlex.join(words)}"
            return await super().handle_websocket(request)
        finally:
            self._pages.discard(page)

    def _revive(self) -> None:
        self.process.poll()
        if self.process.phase is Phase.ENDED:
            self.process.stop()
            self.process = _begun(self._start)


def serve_web(start: StartBench, host: str, port: int) -> None:
    """Show a bench in browsers until a signal comes; then end it.

    Args:
        start: starts the bench.
        host: address to listen at.
        port: TCP port; 0 for a free one.

    Raises:
        UnavailableError: the port is taken, or the bench does not begin.
    """
    # A page's dashboard may take longer to end than the loop: no news to whoever has just pressed Ctrl-C.
    logging.getLogger("asyncio").setLevel(logging.ERROR)
    sys.unraisablehook = _but_for_closed_loops(sys.unraisablehook)
    with _listening(host, port) as listener:
        token = secrets.token_urlsafe(_TOKEN_BYTES)
        dashboard = WebDashboard(start, token)
        try:
            Console().data(f"http://{_reachable(host)}:{listener.getsockname()[1]}/{token}/")
            if host not in _LOOPBACK:
                Console().narrate("not encrypted: anybody who reads the traffic or has the address can watch and drive")
            Console().narrate("stop with Ctrl-C")
            asyncio.run(_serve(dashboard, listener))
        finally:
            interruption.ignore()
            dashboard.process.stop()


def _but_for_closed_loops(hook: Callable[[Any], object]) -> Callable[[Any], None]:
    """Return a hook that passes over what asyncio's pipes say when they are let go of after their loop."""

    def hear(unraisable: Any) -> None:
        if str(unraisable.exc_value) != "Event loop is closed":
            hook(unraisable)

    return hear


async def _serve(dashboard: WebDashboard, listener: socket.socket) -> None:
    """Answer until a signal comes; a second one changes nothing."""
    ended = asyncio.Event()
    for number in interruption.ENDINGS:
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    runner = web.AppRunner(await dashboard.make(), access_log=None, shutdown_timeout=_GOODBYE_S)
    await runner.setup()
    await web.SockSite(runner, listener).start()
    await ended.wait()
    await runner.cleanup()


def _begun(start: StartBench) -> BenchProcess:
    process = start()
    try:
        while process.phase is Phase.STARTING:
            process.poll()
            select.select((), (), (), _LOOK_EVERY_S)
    except BaseException:
        process.stop()
        raise
    if process.phase is Phase.ENDED:
        cause = process.cause
        process.stop()
        raise UnavailableError(cause)
    return process


def _listening(host: str, port: int) -> contextlib.closing[socket.socket]:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return contextlib.closing(socket.create_server((host, port), family=family))
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(f"cannot listen: {reason}", where=f"--web {port} at {host}") from error


def _reachable(host: str) -> str:
    if host in _EVERYWHERE:
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


async def _add_headers(_request: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(_HEADERS)
