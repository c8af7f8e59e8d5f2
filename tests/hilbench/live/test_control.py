"""The socket of a bench: who has taken leave, what is answered, and what nobody can bring it down with."""

from __future__ import annotations

import json

import pytest

from hilbench.clock import Scheduler
from hilbench.driving.control import Control
from hilbench.driving.local_socket import connect_to
from hilbench.testing import FakeHostClock


class There:
    """A control socket of a bench whose time stands still, and clients at it."""

    def __init__(self, path):
        self.path = path
        self.asked = []
        self.control = Control(Scheduler(), path, self.asked.append)
        self.clients = []

    def join(self):
        self.clients.append(connect_to(self.path))
        self.control.wait()
        return self.clients[-1]

    def say(self, client, line):
        client.sendall(line + b"\n")
        self.control.wait()
        return json.loads(client.recv(65536))

    def do(self, client, name):
        assert self.say(client, json.dumps({"id": 1, "do": name}).encode()) == {"id": 1, "ok": True}

    def leave(self, client):
        client.close()
        self.control.wait()


@pytest.fixture
def there(tmp_path):
    made = There(tmp_path / "control")
    yield made
    for client in made.clients:
        client.close()
    made.control.close()


def test_whoever_leaves_last_says_whether_the_bench_goes_on(there):
    first, second = there.join(), there.join()
    there.do(first, "hello")
    there.do(second, "hello")
    there.do(first, "farewell")
    there.leave(first)
    assert there.control.left_ns is None
    there.leave(second)  # it has died: the farewell was another's
    assert (there.control.left_ns, there.control.farewell) == (0, False)


def test_a_farewell_stands_whatever_others_do_before_and_after(there):
    first, second = there.join(), there.join()
    there.do(second, "farewell")
    there.do(first, "hello")
    there.leave(first)
    there.leave(second)
    assert there.control.farewell
    there.leave(there.join())  # somebody who asks who is there, as 'hilbench attach --list' does
    assert there.control.farewell


def test_a_farewell_counts_that_is_read_together_with_the_end_of_who_said_it(there):
    client = there.join()
    there.do(client, "hello")
    there.control.scheduler.lock(FakeHostClock())  # what is said while time passes is done in its turn
    client.sendall(b'{"do": "farewell"}\n')
    there.control.wait()
    there.leave(client)
    assert there.control.left_ns == 0
    there.control.scheduler.run_until(lambda: False, 1_000_000)
    assert there.control.farewell


def test_last_words_are_heard_of_somebody_who_has_not_waited_for_an_answer(there):
    """He hangs up while an answer is due, and his next words have come but are not read yet."""
    client = there.join()
    there.control.scheduler.lock(FakeHostClock())
    client.sendall(b'{"do": "hello"}\n')
    there.control.wait()
    client.sendall(b'{"do": "quit"}\n')
    client.close()
    there.control.scheduler.run_until(lambda: False, 1_000_000)
    assert there.control.left_ns is None, "cut off"
    there.control.wait()
    there.control.scheduler.run_until(lambda: False, 2_000_000)
    assert [request["do"] for request in there.asked] == ["hello", "quit"]
    there.control.wait()
    assert there.control.left_ns is not None


@pytest.mark.parametrize("line", [b"[" * 4000, b'{"id":' * 600, b"\xff", b"", b"null", b'{"id": NaN}', b"9" * 4000])
def test_nothing_that_is_said_brings_it_down(there, line):
    client = there.join()
    answer = there.say(client, line)
    assert answer["ok"] is (line == b'{"id": NaN}')
    there.do(client, "hello")


def test_who_never_ends_a_line_is_cut_off(there):
    client = there.join()
    client.sendall(b"x" * 5000)
    there.control.wait()
    there.control.wait()
    assert client.recv(1) == b""
    assert there.control.left_ns == 0
