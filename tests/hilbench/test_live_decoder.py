"""Frames that are printed as they pass, for readers that are quick, slow, gone, or there and not reading."""

from __future__ import annotations

import fcntl
import os
import threading

import pytest

from hilbench.decode.live import LiveDecoder
from hilbench.systems.rover.protocol import PKT
from hilbench.terminal.console import Console
from protocols.pkt import PROFILES, RequestTelemetry, encode_command, encode_frame

REQUEST = encode_frame(encode_command(RequestTelemetry()), PROFILES["documented"].client.frames)
MANY = 2000
PIPE_BYTES = 4096


@pytest.fixture
def pipe():
    read, write = os.pipe()
    fcntl.fcntl(write, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    with os.fdopen(read, "rb") as reader, open(write, "w", encoding="utf-8") as writer:
        yield reader, writer


def decoder_to(writer, patience_s=600.0):
    return LiveDecoder(PKT, PKT.options(), Console(out=writer), as_json=False, patience_s=patience_s)


def test_all_is_printed_where_somebody_reads(pipe):
    reader, writer = pipe
    decoder = decoder_to(writer)
    lines = []
    thread = threading.Thread(target=lambda: lines.extend(reader))
    thread.start()
    for number in range(MANY):
        decoder.take("client", REQUEST, number)
    decoder.close()
    writer.close()
    thread.join()
    assert len(lines) == MANY
    assert (decoder.totals.frames, decoder.skipped, decoder.unread) == (MANY, 0, False)


def test_who_does_not_read_is_not_waited_for(pipe):
    _, writer = pipe
    decoder = decoder_to(writer, patience_s=0.05)
    for number in range(MANY):
        decoder.take("client", REQUEST, number)
    decoder.take("client", REQUEST * MANY, MANY)
    decoder.close()
    assert decoder.unread
    assert 0 < decoder.skipped <= 2 * MANY * len(REQUEST)
    writer.flush()  # nothing is left in it that could be waited for


def test_who_is_gone_is_not_printed_to(pipe):
    reader, writer = pipe
    reader.close()
    decoder = decoder_to(writer)
    for number in range(MANY):
        decoder.take("client", REQUEST, number)
    decoder.close()
    assert not decoder.unread
