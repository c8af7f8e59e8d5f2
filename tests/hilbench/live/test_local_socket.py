"""Sockets of this machine, at paths of any length."""

from __future__ import annotations

import stat

import pytest

from hilbench.driving.local_socket import connect_to, listen_at


@pytest.mark.parametrize("depth", [0, 20])
def test_a_path_may_be_long(tmp_path, depth):
    folder = tmp_path.joinpath(*["a-folder"] * depth)
    folder.mkdir(parents=True, exist_ok=True)
    with listen_at(folder / "control") as listener, connect_to(folder / "control") as client:
        there, _ = listener.accept()
        with there:
            client.sendall(b"hello")
            assert there.recv(16) == b"hello"
    assert stat.S_IMODE((folder / "control").stat().st_mode) & 0o077 == 0


def test_nobody_listens(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        connect_to(tmp_path / "control")
    with pytest.raises(OSError, match="No such file"):
        listen_at(tmp_path / "nowhere" / "control")
