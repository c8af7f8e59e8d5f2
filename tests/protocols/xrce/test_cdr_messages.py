"""Messages in CDR: bytes worked out by hand, any message of any definition, any bytes; and what others make of them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.xrce import LocalProtocolError, RemoteProtocolError
from protocols.xrce.cdr import (
    Field,
    FieldType,
    MessageDefinition,
    MessageTypes,
    decapsulate,
    encapsulate,
    parse_message,
)
from tests.each import each
from tests.share import examples

FILES = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/Empty": "",
    "demo/Point": "float64 x\nfloat64 y 2.5",
    "demo/Mixed": "uint8 a\nfloat64 b\nuint16 c\nbool d true",
    "demo/Texts": "string one\nstring<=3 two 'abc'\nstring[] many",
    "demo/Arrays": "float32[2] two\nuint8[] data\nint16[<=3] some [7]\nfloat64[] none\nbool[] flags",
    "demo/Long": f"uint8[{2**32 - 1}] bytes\nstring[{2**32 - 1}] texts",
    "demo/Pair": "string[2] names\nPoint[1] at\nuint8[2] bytes\nint16[2] numbers",
    "demo/Nested": "std_msgs/Header header\nPoint[] path\nstd_msgs/Empty nothing\nuint8 end 255",
}


def types_of(files):
    types = MessageTypes()
    for name, text in files.items():
        types.add(parse_message(name, text))
    return types


TYPES = types_of(FILES)

VECTORS = [
    # DDS-XTypes 1.3, 7.4.1: numbers at multiples of their size, up to 8
    ("demo/msg/Mixed", {"a": 1, "b": 1.0, "c": 2, "d": False},
     "01 00 00 00 00 00 00 00  00 00 00 00 00 00 F0 3F  02 00  00"),
    ("demo/msg/Mixed", {"a": 1}, "01 00 00 00 00 00 00 00  00 00 00 00 00 00 00 00  00 00  01"),
    ("demo/msg/Point", {"x": -0.5}, "00 00 00 00 00 00 E0 BF  00 00 00 00 00 00 04 40"),
    # 7.4.1.1.2: a string is its length with its NUL, and its bytes
    ("demo/msg/Texts", {"one": "", "many": ["é", "b"]},
     "01 00 00 00 00 00 00 00  04 00 00 00 61 62 63 00  02 00 00 00  03 00 00 00 C3 A9 00 00  02 00 00 00 62 00"),
    # 7.4.1.1.3: an array has no length; nothing is aligned for the elements of an empty sequence
    ("demo/msg/Arrays", {"two": [0.5, -2.0], "data": b"\1\2\3", "flags": [True, False]},
     "00 00 00 3F 00 00 00 C0  03 00 00 00 01 02 03 00  01 00 00 00 07 00 00 00  00 00 00 00  02 00 00 00 01 00"),
    # nothing said: as many empty strings, messages and numbers as there have to be
    ("demo/msg/Pair", {},
     ("01 00 00 00 00 00 00 00  01 00 00 00 00 00 00 00  00 00 00 00 00 00 00 00  00 00 00 00 00 00 04 40"
      "  00 00  00 00 00 00")),
    # a message without fields is one byte, as in ROS 2's C structures
    ("std_msgs/msg/Empty", {}, "00"),
    ("demo/msg/Nested", {"header": {"stamp": {"sec": -1, "nanosec": 5}, "frame_id": "map"}, "path": [{"x": 1.0}]},
     ("FF FF FF FF 05 00 00 00  04 00 00 00 6D 61 70 00  01 00 00 00 00 00 00 00"
      "  00 00 00 00 00 00 F0 3F  00 00 00 00 00 00 04 40  00 FF")),
]  # fmt: skip
BIG = [
    ("demo/msg/Mixed", {"a": 1, "b": 1.0, "c": 2, "d": False},
     "01 00 00 00 00 00 00 00  3F F0 00 00 00 00 00 00  00 02  00"),
    ("demo/msg/Arrays", {"two": [0.5, -2.0], "data": b"\1\2\3", "flags": [True, False]},
     "3F 00 00 00 C0 00 00 00  00 00 00 03 01 02 03 00  00 00 00 01 00 07 00 00  00 00 00 00  00 00 00 02 01 00"),
]  # fmt: skip


def test_these_messages_are_these_bytes_and_back():
    for vectors, little_endian in ((VECTORS, True), (BIG, False)):
        for name, message, text in vectors:
            data = TYPES.encode(name, message, little_endian=little_endian)
            assert data.hex() == text.replace(" ", "").lower(), name
            found = TYPES.decode(name, data, little_endian=little_endian)
            assert TYPES.encode(name, found, little_endian=little_endian) == data, name
            assert {key: found[key] for key in message if not isinstance(message[key], dict | list)} == {
                key: value for key, value in message.items() if not isinstance(value, dict | list)
            }, name
    assert TYPES.decode("demo/msg/Nested", bytes.fromhex(VECTORS[-1][2])) == {
        "header": {"stamp": {"sec": -1, "nanosec": 5}, "frame_id": "map"},
        "path": [{"x": 1.0, "y": 2.5}],
        "nothing": {},
        "end": 255,
    }


def test_the_four_bytes_before_data_say_their_order():
    assert encapsulate(b"x") == b"\0\1\0\0x"
    assert decapsulate(encapsulate(b"x", little_endian=False)) == (b"x", False)
    for wrong in (b"", b"\0\1\0", b"\0\3\0\0x", b"\0\7\0\0"):
        with pytest.raises(RemoteProtocolError, match="does not begin CDR"):
            decapsulate(wrong)


@each(
    ("name", "message", "wrong"),
    [
        ("demo/msg/Point", {"z": 1.0}, "no field z"),
        ("demo/msg/Point", [1.0], "no message"),
        ("demo/msg/Point", {"x": "1"}, "x: '1' is no number"),
        ("demo/msg/Mixed", {"a": 256}, "a: 256 is no number"),
        ("demo/msg/Mixed", {"d": "false"}, "d: 'false' is no number"),
        ("demo/msg/Texts", {"one": b"bytes"}, "one: b'bytes' is no string"),
        ("demo/msg/Texts", {"one": "\ud800"}, "one: "),
        ("demo/msg/Texts", {"two": "\ud800"}, "two: "),
        ("demo/msg/Texts", {1: "a", "x": ""}, "no field 1, x"),
        ("demo/msg/Texts", {"two": "abcd"}, "two: 'abcd' is longer than 3 bytes"),
        ("demo/msg/Texts", {"many": "abc"}, "many: 'abc' is no list"),
        ("demo/msg/Arrays", {"two": [1.0]}, "two: 1 values where there are 2"),
        ("demo/msg/Arrays", {"some": [1, 2, 3, 4]}, "some: 4 values where there are 3 at most"),
        ("demo/msg/Arrays", {"two": 1.0}, "two: 1.0 are no numbers"),
        ("demo/msg/Arrays", {"data": [256]}, "data: "),
        ("demo/msg/Arrays", {"none": [1e999, "x"]}, "none: "),
        ("demo/msg/Nested", {"header": {"stamp": {"sec": 1 << 31}}}, "header: stamp: sec: 2147483648 is no number"),
        ("demo/msg/Absent", {}, "demo/msg/Absent is not defined"),
    ],
)
def test_what_does_not_fit_is_refused_and_says_where(name, message, wrong):
    with pytest.raises(LocalProtocolError) as caught:
        TYPES.encode(name, message)
    assert wrong in str(caught.value)


@each(
    ("name", "text", "wrong"),
    [
        ("demo/msg/Mixed", "01", "wanted"),
        ("demo/msg/Mixed", "01 00 00 00 00 00 00 00  00 00 00 00 00 00 F0 3F  02 00  02", "a boolean is 2"),
        ("demo/msg/Texts", "02 00 00 00 61 62", "does not end in NUL"),
        ("demo/msg/Texts", "FF FF FF FF 61 00", "4294967295"),
        ("demo/msg/Texts", "00 00 00 00 05 00 00 00 61 62 63 64 00", "longer than 3 bytes"),
        ("demo/msg/Arrays", "00 00 00 00 00 00 00 00 00 00 00 00 04 00 00 00 00 00 00 00", "a sequence of 4"),
        ("std_msgs/msg/Empty", "", "wanted"),
        ("demo/msg/Long", "01 02", "4294967295 bytes are wanted"),
    ],
)
def test_bytes_that_make_no_sense(name, text, wrong):
    with pytest.raises(RemoteProtocolError, match=wrong):
        TYPES.decode(name, bytes.fromhex(text))


def test_definitions_that_do_not_go_together():
    with pytest.raises(LocalProtocolError, match="demo/msg/Point is defined twice, and not alike"):
        types_of(FILES).add(parse_message("demo/Point", "float32 x"))
    types_of(FILES).add(parse_message("demo/Point", FILES["demo/Point"]))
    circle = types_of({"demo/A": "B[] b", "demo/B": "A[] a"})
    with pytest.raises(LocalProtocolError, match="demo/msg/A holds itself, by demo/msg/A and demo/msg/B"):
        circle.encode("demo/msg/A", {})
    deep = types_of({f"demo/A{level}": f"A{level + 1} a" for level in range(1000)})
    with pytest.raises(LocalProtocolError, match="demo/msg/A100 is 100 messages deep in demo/msg/A0"):
        deep.encode("demo/msg/A0", {})
    with pytest.raises(LocalProtocolError, match="wstring is neither written nor read here"):
        types_of({"demo/Wide": "wstring a"}).encode("demo/msg/Wide", {})
    with pytest.raises(LocalProtocolError, match="demo/msg/C is not defined"):
        types_of({"demo/A": "C c"}).decode("demo/msg/A", b"")


RANGES = {
    **{f"{sign}int{bits}": (0, (1 << bits) - 1) for sign in ("u",) for bits in (8, 16, 32, 64)},
    **{f"int{bits}": (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **dict.fromkeys(("byte", "char"), (0, 255)),
}
BYTES = ("uint8", "byte", "char")
SINGLE = {
    "bool": st.booleans(),
    "string": st.text(st.characters(exclude_categories=("Cs",)), max_size=5),
    "float32": st.floats(width=32, allow_nan=False),
    "float64": st.floats(allow_nan=False),
    **{name: st.integers(*both) for name, both in RANGES.items()},
}


@st.composite
def kinds(draw, messages):
    base = draw(st.sampled_from([*SINGLE, *messages]))
    shape = draw(st.sampled_from(["one", "any", "fixed", "bounded"]))
    size = draw(st.integers(1, 4)) if shape in ("fixed", "bounded") else None
    bound = 20 if base == "string" and draw(st.booleans()) else None
    return FieldType(base=base, string_bound=bound, is_array=shape != "one", size=size, is_bounded=shape == "bounded")


@st.composite
def worlds(draw):
    """Two definitions, of which one may hold the other, and a message of the last one."""
    definitions = {}
    for number in range(2):
        found = draw(st.lists(kinds(list(definitions)), max_size=4))
        fields = tuple(Field(name=f"f{at}", type=kind) for at, kind in enumerate(found))
        name = f"demo/msg/M{number}"
        definitions[name] = MessageDefinition(name=name, fields=fields)
    return definitions, draw(message_of(definitions, name))


def message_of(definitions, name):
    return st.fixed_dictionaries({one.name: value_of(definitions, one.type) for one in definitions[name].fields})


def value_of(definitions, kind):
    one = SINGLE[kind.base] if kind.base in SINGLE else message_of(definitions, kind.base)
    if not kind.is_array:
        return one
    least, most = (kind.size, kind.size) if kind.size and not kind.is_bounded else (0, kind.size or 3)
    if kind.base in BYTES:
        return st.binary(min_size=least, max_size=most)
    return st.lists(one, min_size=least, max_size=most)


@settings(max_examples=examples(200))
@given(worlds(), st.booleans())
def test_any_message_of_any_definition_is_read_as_it_was_written(world, little_endian):
    definitions, message = world
    types = MessageTypes()
    for definition in definitions.values():
        types.add(definition)
    data = types.encode("demo/msg/M1", message, little_endian=little_endian)
    assert types.decode("demo/msg/M1", data, little_endian=little_endian) == message
    for length in range(len(data)):
        with pytest.raises(RemoteProtocolError):
            types.decode("demo/msg/M1", data[:length], little_endian=little_endian)


@settings(max_examples=examples(500))
@given(st.sampled_from([name.replace("/", "/msg/") for name in FILES]), st.binary(), st.booleans())
def test_any_bytes_raise_nothing_but_the_documented_error(name, data, little_endian):
    try:
        found = TYPES.decode(name, data, little_endian=little_endian)
    except RemoteProtocolError:
        return
    again = TYPES.encode(name, found, little_endian=little_endian)
    assert math.isclose(len(again), len(data), abs_tol=len(data))  # what is behind the message is passed over
    assert repr(TYPES.decode(name, again, little_endian=little_endian)) == repr(found)


def text_of(definition):
    """The `.msg` file of a definition."""
    lines = []
    for field in definition.fields:
        kind = field.type
        bound = "" if kind.string_bound is None else f"<={kind.string_bound}"
        size = "" if kind.size is None else f"<={kind.size}" if kind.is_bounded else f"{kind.size}"
        lines.append(f"{kind.base}{bound}{f'[{size}]' if kind.is_array else ''} {field.name}")
    return "\n".join(lines)


@settings(max_examples=examples(100))
@given(worlds())
def test_any_definition_is_read_from_its_file(world):
    definitions, _ = world
    for name, definition in definitions.items():
        assert parse_message(name, text_of(definition)) == definition


def as_rosbags(store, name, message, definitions):
    """A message as an object of rosbags, whose arrays of numbers are numpy's."""
    numpy = pytest.importorskip("numpy")
    values = {}
    for field in definitions[name].fields:
        value, kind = message[field.name], field.type
        if kind.base in definitions:
            inner = [as_rosbags(store, kind.base, one, definitions) for one in (value if kind.is_array else [value])]
            value = inner if kind.is_array else inner[0]
        elif kind.is_array and kind.base != "string":
            dtype = {"byte": "uint8", "char": "uint8"}.get(kind.base, kind.base)
            value = numpy.array(list(value), dtype)
        values[field.name] = value
    return store.types[name](**values)


@pytest.mark.exhaustive("needs rosbags, which is not among what the tests install: its CDR is another one's")
def test_rosbags_makes_and_reads_the_same():
    typesys = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed")

    @settings(max_examples=examples(300))
    @given(worlds(), st.booleans())
    def check(world, little_endian):
        definitions, message = world
        store, types = typesys.get_typestore(typesys.Stores.EMPTY), MessageTypes()
        for name, definition in definitions.items():
            types.add(definition)
            store.register(typesys.get_types_from_msg(text_of(definition), name))
        theirs = as_rosbags(store, "demo/msg/M1", message, definitions)
        ours = types.encode("demo/msg/M1", message, little_endian=little_endian)
        data = encapsulate(ours, little_endian=little_endian)
        assert bytes(store.serialize_cdr(theirs, "demo/msg/M1", little_endian=little_endian)) == data
        back = store.deserialize_cdr(data, "demo/msg/M1")
        assert bytes(store.serialize_cdr(back, "demo/msg/M1", little_endian=little_endian)) == data

    check()
