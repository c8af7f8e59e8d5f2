"""Processes of the command that begin at once: forked from one that has imported already what a command needs.

Signals, descriptors, terminals and exit codes are those of a process of its own; only what an interpreter does as it
begins is not. Tests of that, and of what is imported, start one anew.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import io
import json
import os
import select
import selectors
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

HILBENCH = "import sys; from hilbench.__main__ import main; sys.exit(main())"
PYTEST = """\
import sys
import pytest

plugins = [f"-pno:{name}" for name in ("hypothesispytest", "xdist", "xdist.looponfail")]  # nobody here wants them
sys.exit(pytest.main([*plugins, *sys.argv[1:]]))
"""
ALREADY_IMPORTED = ("-W", "ignore:Module already imported so cannot be rewritten")
"""What pytest, told to make errors of warnings, is told besides where ours is imported beforehand."""
PATIENCE_S = 600
CLOSED = object()
"""A stream that is closed as the process begins."""

OF_OTHERS = """
import elftools.elf.elffile, msgspec, numpy, serial
import _pytest.config; _pytest.config.get_config()
"""
COMMANDS = f"""{OF_OTHERS}
import importlib, importlib.metadata, pkgutil
import vcd
import hilbench.__main__, hilbench.bench.physics, hilbench.check.bench_provider, hilbench.check.pytest_run
import hilbench.check.runner, hilbench.cli.siblings, hilbench.commands.check, hilbench.commands.doctor
import hilbench.commands.init, hilbench.commands.proxy, hilbench.commands.run, hilbench.commands.serve
import hilbench.commands.validate, hilbench.doctor.report, hilbench.doctor.software, hilbench.driving.rig
import hilbench.mcu.command_line, hilbench.mcu.under_test, hilbench.serving.run, hilbench.serving.boards
import hilbench.serving.proxy, hilbench.serving.serve, hilbench.terminal.settings, hilbench.udev.installing
import targets.mcu.machine, targets.mcu.stm32f1.chip, worlds.plane

for group in ("hilbench.protocols", "hilbench.systems"):
    for point in importlib.metadata.entry_points(group=group):
        if point.value.startswith("hilbench."):
            point.load()
            package = importlib.import_module(point.module.rpartition(".")[0])
            for module in pkgutil.iter_modules(package.__path__, package.__name__ + "."):
                if module.name.endswith((".cases", ".peer", ".provider", ".robot")):
                    importlib.import_module(module.name)
"""
"""What is imported beforehand: all that a command needs; or, where pytest is to import ours itself, that of others."""


class Forkable:
    """The process that is forked from. It ends when it is closed.

    Args:
        environment: what is added to the environment, as the interpreter begins.
        imported: the statements that import.
    """

    def __init__(self, environment=(), imported=COMMANDS):
        self._ours, its = socket.socketpair()
        command = [sys.executable, "-P", __file__, str(its.fileno()), imported]
        self._process = subprocess.Popen(command, env=os.environ | dict(environment), pass_fds=[its.fileno()])
        its.close()

    def run(self, *words, **more):
        """Run a command to its end, and return it with what it printed as `output` and `error`."""
        with self.start(*words, stdout=more.pop("stdout", subprocess.PIPE), **more) as process:
            process.communicate()
            return process

    def start(self, *words, program=HILBENCH, cwd=None, env=(), stdin=None, stdout=None, stderr=subprocess.PIPE):
        """Start a command. A stream is a descriptor, PIPE, CLOSED or None, which leads nowhere.

        Its environment is that in which the process that is forked from began, with `env` added.
        """
        status, reporter = socket.socketpair()
        nowhere = os.open(os.devnull, os.O_RDWR)
        pipes, given, opened = {}, [], [nowhere, reporter.detach()]
        for number, stream in enumerate((stdin, stdout, stderr)):
            if stream is subprocess.PIPE:
                read, write = os.pipe()
                pipes[number] = read
                opened.append(write)
                given.append(write)
            else:
                given.append(nowhere if stream in (None, CLOSED) else stream)
        request = {
            "words": [os.fsencode(word).hex() for word in words],
            "program": program,
            "cwd": os.fspath(cwd or Path.cwd()),
            "env": dict(env),
            "closed": [number for number, stream in enumerate((stdin, stdout, stderr)) if stream is CLOSED],
        }
        data = json.dumps(request).encode()
        socket.send_fds(self._ours, [len(data).to_bytes(4, "big")], [opened[1], *given])
        self._ours.sendall(data)
        for descriptor in opened:
            os.close(descriptor)
        return Process(status, pipes)

    def close(self):
        self._ours.close()
        self._process.wait()


class Process:
    """A forked process, with what is used here of a `subprocess.Popen`.

    Attributes:
        output, error: what has been read of its streams by `communicate`.
        said: what has been read of its standard error by `hear`.
    """

    def __init__(self, status, pipes):
        self._status = status
        status.settimeout(PATIENCE_S)
        self.pid = self._hear_number()
        self.returncode = None
        self.stdout = open(pipes[1], "rb", buffering=0) if 1 in pipes else None  # noqa: SIM115 - closed by __exit__
        self.stderr = open(pipes[2], "rb", buffering=0) if 2 in pipes else None  # noqa: SIM115 - closed by __exit__
        self.output = self.error = self.said = ""

    def hear(self, words, times=1):
        """Wait until it has said these words so many times; return all that it has said."""
        while self.said.count(words) < times:
            assert select.select((self.stderr,), (), (), PATIENCE_S)[0], self.said
            more = self.stderr.read(4096)
            assert more, self.said
            self.said += more.decode()
        return self.said

    def communicate(self):
        """Read its streams to their ends, and wait for its own; return what was read."""
        heard = {stream: b"" for stream in (self.stdout, self.stderr) if stream is not None}
        with selectors.DefaultSelector() as selector:
            for stream in heard:
                selector.register(stream, selectors.EVENT_READ)
            while selector.get_map():
                ready = selector.select(PATIENCE_S)
                assert ready, f"it neither ends nor says anything: {heard}"
                for key, _ in ready:
                    more = key.fileobj.read(65536)
                    heard[key.fileobj] += more
                    if not more:
                        selector.unregister(key.fileobj)
        self.output, self.error = (
            heard.get(stream, b"").decode(errors="backslashreplace") for stream in (self.stdout, self.stderr)
        )
        self.wait()
        return self.output, self.error

    def wait(self):
        if self.returncode is None:
            self.returncode = self._hear_number()
        return self.returncode

    def _hear_number(self):
        said = self._status.recv(4, socket.MSG_WAITALL)
        assert said, "what it is forked from has ended, or could not begin"
        return int.from_bytes(said, "big", signed=True)

    def hang_up(self):
        """Read no more of its output."""
        self.stdout.close()
        self.stdout = None

    def send_signal(self, number):
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.returncode is None:
            self.send_signal(signal.SIGKILL)
            self.wait()
        for stream in (self.stdout, self.stderr, self._status):
            if stream is not None:
                stream.close()


# --- in the process that is forked from


def _forked_when_asked(connection):
    """Fork for each request; return, in what was forked, the request. The process itself ends here."""
    while True:
        length, descriptors, _, _ = socket.recv_fds(connection, 4, 4)
        if not length:
            with contextlib.suppress(ChildProcessError):
                while True:
                    os.waitpid(-1, 0)
            os._exit(0)
        request = json.loads(connection.recv(int.from_bytes(length, "big"), socket.MSG_WAITALL))
        if os.fork() == 0:
            connection.close()
            return _begun(request, *descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass


def _begun(request, reporter, *streams):
    """Fork once more; tell its number and how it ends, and return, in it, with its streams in their places."""
    child = os.fork()
    if child:
        for descriptor in streams:
            os.close(descriptor)
        os.write(reporter, child.to_bytes(4, "big"))
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        with contextlib.suppress(OSError):
            os.write(reporter, code.to_bytes(4, "big", signed=True))
        os._exit(0)
    os.close(reporter)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
    for stream in set(streams):
        os.close(stream)
    for number in request["closed"]:
        os.close(number)
    os.chdir(request["cwd"])
    os.environ.update(request["env"])
    sys.argv = ["hilbench", *(os.fsdecode(bytes.fromhex(word)) for word in request["words"])]
    sys.stdin, sys.stdout, sys.stderr = (_stream(*named) for named in enumerate((sys.stdin, sys.stdout, sys.stderr)))
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr
    return request["program"]


def _stream(number, usual):
    """Return a standard stream as an interpreter makes it."""
    try:
        raw = open(number, "wb" if number else "rb", closefd=False)  # noqa: SIM115 - a standard stream
    except OSError:
        return None
    interactive = number == 2 or raw.isatty()
    return io.TextIOWrapper(raw, encoding=usual.encoding, errors=usual.errors, line_buffering=interactive)


def _end(ended):
    """Do what an interpreter does at its end, but for clearing away a thousand modules."""
    threading._shutdown()
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    os._exit(ended.code or 0)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C at the tests ends this one by its connection
    asked = socket.socket(fileno=int(sys.argv[1]))
    asked.set_inheritable(False)
    exec(sys.argv[2], {})
    gc.freeze()
    program = _forked_when_asked(asked)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        exec(program, {"__name__": "__main__"})
    except SystemExit as ended:
        _end(ended)
