"""The dashboard in a browser, served and fetched on loopback: with its token everything, without it nothing."""

from __future__ import annotations

import asyncio
import http.client
import importlib.util
import os
import signal
import socket
import subprocess
import sys
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest

from hilbench.cli import main

pytestmark = pytest.mark.skipif(importlib.util.find_spec("textual_serve") is None, reason="it is not installed")

PATIENCE_S = 600


@pytest.fixture
def environment(tmp_path):
    return {**os.environ, "XDG_RUNTIME_DIR": str(tmp_path), "XDG_STATE_HOME": str(tmp_path / "state")}


@pytest.fixture
def served(command, tmp_path, environment):
    """Serve a bench; yield the process and its address, and see it end."""
    process = subprocess.Popen(
        [*command, "rover-model", "--web"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        cwd=tmp_path, env=environment, text=True, start_new_session=True,
    )  # fmt: skip
    address = urlsplit(process.stdout.readline().strip())
    yield process, address
    if process.poll() is None:
        process.kill()
    process.communicate()


def fetch(address, path, **headers):
    """Return status, headers and body."""
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=PATIENCE_S)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, answer.headers, answer.read()
    connection.close()
    return found


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "x3JJHMbDL1EzLkh9GBhXDw==",
}


async def look(url, keys):
    """Open a page's websocket, press keys when something is drawn, and read until it is asked how to leave."""
    import aiohttp

    async with aiohttp.ClientSession() as session, session.ws_connect(url, timeout=aiohttp.ClientWSTimeout()) as page:
        drawn, pressed = b"", False
        async for message in page:
            drawn += message.data if message.type is aiohttp.WSMsgType.BINARY else b""
            if not pressed and b"rover-model" in drawn:
                await page.send_json(["stdin", keys])
                pressed = True
            if b"Leave it how?" in drawn:
                return drawn
    return drawn


def test_a_dashboard_that_outlives_the_loop_is_no_news_and_anything_else_is():
    from hilbench.tui.web import _but_for_closed_loops

    heard = []
    hook = _but_for_closed_loops(heard.append)
    for error in (RuntimeError("Event loop is closed"), RuntimeError("something else")):
        hook(SimpleNamespace(exc_value=error))
    assert [str(one.exc_value) for one in heard] == ["something else"]


@pytest.mark.real_time("a bench, what serves it and what draws it are processes of their own")
def test_a_page_is_shown_with_the_token_and_nothing_without(served, tmp_path):
    process, address = served
    assert (address.scheme, address.hostname) == ("http", "127.0.0.1")
    token = address.path.strip("/")
    assert len(token) >= 32

    status, headers, page = fetch(address, address.path)
    assert status == 200
    assert f"ws://127.0.0.1:{address.port}/{token}/ws".encode() in page
    assert headers["Cache-Control"] == "no-store"
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    assert fetch(address, f"/{token}/static/js/textual.js")[0] == 200

    wrong = (
        "/",
        "/ws",
        "/static/js/textual.js",
        f"/{token[:-1]}/",
        f"/{token}x/ws",
        f"//{token}/",
        f"/{token.lower()}/",
    )
    for path in wrong:
        for headers in ({}, UPGRADE):
            status, _, said = fetch(address, path, **headers)
            assert (status, token.encode() in said) == (403, False), path

    drawn = asyncio.run(
        asyncio.wait_for(look(f"ws://127.0.0.1:{address.port}/{token}/ws?width=120&height=40", "q"), PATIENCE_S)
    )
    assert b"Leave it how?" in drawn

    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, said) == (0, "stop with Ctrl-C\n")
    assert not list((tmp_path / "hilbench").iterdir())


@pytest.mark.exhaustive("the gate ends a server whose page has been left; here one is open")
def test_a_page_that_is_open_does_not_hold_up_the_end(served, tmp_path):
    process, address = served
    with socket.create_connection((address.hostname, address.port)) as page:
        lines = [f"GET {address.path}ws HTTP/1.1", f"Host: {address.netloc}"]
        lines += [f"{name}: {value}" for name, value in UPGRADE.items()]
        page.sendall("\r\n".join([*lines, "", ""]).encode())
        page.settimeout(PATIENCE_S)
        seen = b""
        while b"rover-model" not in seen:
            seen += page.recv(65536)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert not list((tmp_path / "hilbench").iterdir())


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["nonsense.toml", "--web"], 2, "nonsense.toml: "),
        (["rover-model", "--web", "70000"], 2, "--web: '70000' is no TCP port"),
        (["--web", "rover-model"], 2, "--web: 'rover-model' is no TCP port; write the bench first"),
        (["rover-model", "--web-host", "0.0.0.0"], 2, "--web-host: goes with --web"),
        (["rover-model", "--web", "--web-host", "203.0.113.1"], 3, "--web 0 at 203.0.113.1: cannot listen"),
        (["rover-model", "--target", "serial:/dev/none", "--web"], 3, "the bench ended with exit code 3: /dev/none"),
    ],
)
def test_what_cannot_be_served_is_said_in_one_line(words, code, said, capfd, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr("hilbench.tui.web._serve", lambda *_: pytest.fail("it is served"))
    assert main(words) == code
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith(f"hilbench: {said}")


def test_who_lacks_what_serves_it_is_told_how_to_get_it(capfd, monkeypatch):
    monkeypatch.setitem(sys.modules, "textual_serve", None)
    assert main(["rover-model", "--web"]) == 3
    missing = "the package that shows the dashboard in a browser is not installed"
    assert capfd.readouterr() == ("", f"hilbench: --web: {missing}; pip install 'hilbench[web]'\n")
