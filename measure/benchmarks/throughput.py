"""The rate of a reader of frames, beside that of a plain loop over the bytes."""

from __future__ import annotations

import statistics
import time

ROUNDS = 7
STREAM_BYTES = 400_000


def cut(data, size):
    return [data[at : at + size] for at in range(0, len(data), size)]


def rate(read, parts):
    """Median rate in MB/s, and the number of frames found."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        frames = read(parts)
        times.append(time.perf_counter() - start)
    return sum(map(len, parts)) / statistics.median(times) / 1e6, frames


def compare(make_ours, frame, make_plain, parts):
    """Return the rate of ours, beside that of a plain loop, in words; ours has to find as many frames at least."""

    def read_ours(parts):
        reader = make_ours()
        return sum(isinstance(item, frame) for part in parts for item in reader.receive(part, 0))

    def read_plainly(parts):
        reader = make_plain()
        for part in parts:
            reader.receive(part)
        return len(reader.frames)

    ours, frames = rate(read_ours, parts)
    plain, plain_frames = rate(read_plainly, parts)
    assert frames >= plain_frames > 0
    return f"{ours:.2f} MB/s, plain loop {plain:.2f} MB/s, ratio {ours / plain:.2f}"
