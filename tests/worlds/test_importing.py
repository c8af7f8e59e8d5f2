"""A library that is imported while Ctrl-C comes is imported all the same, and then Ctrl-C is."""

from __future__ import annotations

import signal
import sys
import threading

import pytest

from worlds.importing import import_whole

# As NumPy's C API does: whatever has gone wrong is an ImportError.
LIBRARY = """
try:
    import signal
    signal.raise_signal(signal.{name})
    for _ in range(1000): pass
except BaseException:
    raise ImportError("numpy.core.multiarray failed to import") from None
whole = True
"""


@pytest.fixture
def library(tmp_path, monkeypatch):
    """Write a library during whose import a signal comes; return its name."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name):
        (tmp_path / f"lib_{name.lower()}.py").write_text(LIBRARY.format(name=name))
        return f"lib_{name.lower()}"

    yield write
    for name in [name for name in sys.modules if name.startswith("lib_sig")]:
        del sys.modules[name]


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_is_handled_when_the_library_is_there(library, name):
    def handler(_number, _frame):
        raise KeyboardInterrupt

    number = getattr(signal, name)
    before = signal.signal(number, handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            import_whole(library(name))
        assert signal.getsignal(number) is handler
    finally:
        signal.signal(number, before)
    assert sys.modules[f"lib_{name.lower()}"].whole


def test_one_that_is_not_there_is_no_module():
    with pytest.raises(ModuleNotFoundError):
        import_whole("no_such_library")


def test_in_another_thread_it_is_imported_as_ever():
    found = []
    thread = threading.Thread(target=lambda: found.append(import_whole("json")))
    thread.start()
    thread.join()
    assert found == [sys.modules["json"]]
