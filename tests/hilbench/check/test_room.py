"""The frames of calls that are made with room need no memory of their own."""

from __future__ import annotations

import resource
from concurrent.futures import ThreadPoolExecutor

import pytest

from hilbench.check.room import with_room

CALLS = 1000


def leaf():
    pass


leaf.__code__ = leaf.__code__.replace(co_stacksize=100)  # larger than a frame below, so that none steps over the end


def faults_at(depth):
    """Return how many pages the kernel had to give while a function was called from so far below."""
    if depth:
        return faults_at(depth - 1)
    before = resource.getrusage(resource.RUSAGE_THREAD).ru_minflt
    for _ in range(CALLS):
        leaf()
    return resource.getrusage(resource.RUSAGE_THREAD).ru_minflt - before


def most_faults():
    return max(faults_at(depth) for depth in range(400))


def in_a_thread(function, *arguments):
    """Call it where there are no frames yet: the tests themselves are run with room."""
    with ThreadPoolExecutor() as threads:
        return threads.submit(function, *arguments).result()


def test_no_depth_is_dear():
    if in_a_thread(most_faults) < CALLS:
        pytest.skip("this CPython keeps its chunks: with_room is needed for older ones")
    assert in_a_thread(with_room, most_faults) < CALLS / 10


def test_what_it_calls_has_its_arguments_and_gives_its_result():
    assert with_room(divmod, 7, 2) == (3, 1)
    assert with_room(sorted, [1, 2], reverse=True) == [2, 1]
