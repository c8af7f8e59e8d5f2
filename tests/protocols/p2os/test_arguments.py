"""Arguments: three types, every tolerance, and what is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.p2os import (
    COMMANDS,
    ArgumentForm,
    ArgumentKind,
    BytePacking,
    Command,
    CommandNumber,
    LocalProtocolError,
    RemoteProtocolError,
    Support,
    check_argument_kind,
    decode_command,
    encode_command,
    pack_bytes,
    unpack_bytes,
    unpack_signed_bytes,
)
from protocols.p2os.commands import encode_command_body
from tests.each import each

arguments = st.one_of(st.none(), st.integers(-65535, 65535), st.binary(max_size=195))
commands = st.builds(Command, st.integers(0, 255), arguments)
byte = st.integers(0, 255)


@given(commands)
def test_round_trip(command):
    assert decode_command(encode_command_body(command)) == command


@given(byte, st.binary(max_size=194))
def test_uncounted_nul_is_ignored(number, text):
    body = encode_command_body(Command(number, text), form=ArgumentForm.STRING_WITH_NUL)
    assert body.endswith(b"\0")
    assert decode_command(body) == Command(number, text)


@given(st.binary(min_size=1, max_size=205), st.booleans())
def test_any_body_is_read_or_refused(body, raw_tty):
    try:
        command = decode_command(body, raw_tty=raw_tty)
    except RemoteProtocolError:
        return
    assert command.number == body[0]
    assert isinstance(command.value, int)
    assert isinstance(command.text, bytes)


@given(byte, byte, st.sampled_from(BytePacking))
def test_two_bytes_come_through_in_both_packings(high, low, packing):
    argument = pack_bytes(high, low, packing)
    command = decode_command(encode_command_body(Command(CommandNumber.DIGOUT, argument)))
    assert unpack_bytes(command.value) == (high, low)
    signed = tuple(value - 256 if value > 127 else value for value in (high, low))
    assert unpack_signed_bytes(command.value) == signed
    assert pack_bytes(*signed, packing) == argument


@each("high", [-129, 256])
def test_what_is_no_byte_is_not_packed(high):
    with pytest.raises(LocalProtocolError, match="byte"):
        pack_bytes(high, 0)
    with pytest.raises(LocalProtocolError, match="byte"):
        pack_bytes(0, high)


@each(
    ("body", "expected"),
    [
        ("07 3B", None),
        ("07 1B", None),
        ("07 2B", None),
        ("0B 1B 00 00", 0),
        ("0B 3B FB FB", 0xFBFB),
        ("07 3B 01 00 3B 02 00", 1),
        ("0F 2B 02 41 42 43 44", b"AB"),
    ],
)
def test_tolerated(body, expected):
    assert decode_command(bytes.fromhex(body)).argument == expected


@each("body", ["", "0B 3C 01 00", "0B 3B 01", "0B 1B 01", "0F 2B 05 41 42", "0F 00"])
def test_refused(body):
    with pytest.raises(RemoteProtocolError):
        decode_command(bytes.fromhex(body))


def test_raw_tty_string_only_where_it_is_allowed():
    assert decode_command(bytes.fromhex("2A2B78797A")).argument == b"xyz"
    with pytest.raises(RemoteProtocolError):
        decode_command(bytes.fromhex("2A2B78797A"), raw_tty=False)
    with pytest.raises(RemoteProtocolError):
        decode_command(bytes.fromhex("0F2B78797A"))


@each(
    "command",
    [
        Command(256),
        Command(-1),
        Command(11, 65536),
        Command(11, -65536),
        Command(15, bytes(256)),
        Command(15, bytes(196)),
    ],
)
def test_what_cannot_be_sent(command):
    with pytest.raises(LocalProtocolError):
        encode_command(command)


@each(
    ("command", "right"),
    [
        (Command(CommandNumber.VEL, 200), True),
        (Command(CommandNumber.VEL), True),
        (Command(CommandNumber.VEL, b"200"), False),
        (Command(CommandNumber.SAY, b"x"), True),
        (Command(CommandNumber.SAY, 5), False),
        (Command(CommandNumber.SETO, b"x"), True),
        (Command(CommandNumber.VEL2, 5), True),
        (Command(200, b"x"), True),
        (Command(200, 3), True),
    ],
)
def test_kind_of_the_argument(command, right):
    if right:
        check_argument_kind(command)
    else:
        with pytest.raises(RemoteProtocolError, match=command.name):
            check_argument_kind(command)


def test_the_table_is_whole_and_consistent():
    assert set(COMMANDS) == set(CommandNumber)
    for number, spec in COMMANDS.items():
        assert spec.number == number
        assert spec.name == CommandNumber(number).name
        assert spec.minimum <= spec.maximum
        assert spec.summary
        assert spec.source
        if spec.argument is not ArgumentKind.NONE:
            encode_command(Command(number, b"\1" if spec.argument is ArgumentKind.STRING else spec.maximum))


def test_the_essential_commands_of_a_pioneer_2dx():
    essential = {spec.number for spec in COMMANDS.values() if spec.support is Support.ESSENTIAL}
    assert essential == {
        *(0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 18, 19, 21, 22, 23, 28, 29, 30, 32, 35, 40, 42, 43, 44, 55),
        *range(82, 88),
    }
    assert COMMANDS[CommandNumber.BATTERYINFO].support is Support.QUIET
