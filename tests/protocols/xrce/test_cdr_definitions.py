"""What `.msg` and `.srv` files say, and which cannot be read."""

from __future__ import annotations

import pytest

from protocols.xrce import LocalProtocolError
from protocols.xrce.cdr import Constant, Field, FieldType, MessageDefinition, parse_message, parse_service
from tests.each import each

EVERYTHING = """
# A comment, then an empty line

uint8 NONE = 0    # nothing
int32 LOWEST=-2147483648
uint8 MASK=0xF0
string GREETING="a # in \\"quotes\\""
string PLAIN=two words
float32 HALF=0.5
bool YES=true
int8 mode -1
bool on true
string name 'rob#t'
string<=10 short
float64[3] position [0.0, -1.5, 2]
uint8[] data
int16[<=4] some [1, 2]
string[] names ["a, b", 'c']
string<=5[<=2] shorts
wstring<=5[2] wide ['ä', "ö"]
uint8[] none []
std_msgs/Header header
geometry_msgs/msg/Point[] path
Own[2] own
"""


def test_everything_that_a_message_can_hold():
    found = parse_message("demo/Everything", f"\ufeff{EVERYTHING}")  # as an editor of Windows begins a file
    assert found.name == "demo/msg/Everything"
    assert {one.name: one.value for one in found.constants} == {
        "NONE": 0,
        "LOWEST": -(1 << 31),
        "MASK": 0xF0,
        "GREETING": 'a # in "quotes"',
        "PLAIN": "two words",
        "HALF": 0.5,
        "YES": True,
    }
    assert found.constants[0] == Constant(name="NONE", type=FieldType(base="uint8"), value=0)
    assert {one.name: one.default for one in found.fields if one.default is not None} == {
        "mode": -1,
        "on": True,
        "name": "rob#t",
        "position": (0.0, -1.5, 2.0),
        "some": (1, 2),
        "names": ("a, b", "c"),
        "wide": ("ä", "ö"),
        "none": (),
    }
    assert {one.name: one.type for one in found.fields} == {
        "mode": FieldType(base="int8"),
        "on": FieldType(base="bool"),
        "name": FieldType(base="string"),
        "short": FieldType(base="string", string_bound=10),
        "position": FieldType(base="float64", is_array=True, size=3),
        "data": FieldType(base="uint8", is_array=True),
        "some": FieldType(base="int16", is_array=True, size=4, is_bounded=True),
        "names": FieldType(base="string", is_array=True),
        "shorts": FieldType(base="string", string_bound=5, is_array=True, size=2, is_bounded=True),
        "wide": FieldType(base="wstring", string_bound=5, is_array=True, size=2),
        "none": FieldType(base="uint8", is_array=True),
        "header": FieldType(base="std_msgs/msg/Header"),
        "path": FieldType(base="geometry_msgs/msg/Point", is_array=True),
        "own": FieldType(base="demo/msg/Own", is_array=True, size=2),
    }


def test_a_service_is_two_messages():
    found = parse_service("std_srvs/SetBool", "bool data # e.g. for hardware\n---\nbool success\nstring message\n")
    assert found.name == "std_srvs/srv/SetBool"
    assert found.request.name == "std_srvs/srv/SetBool_Request"
    assert found.request.fields == (Field(name="data", type=FieldType(base="bool")),)
    assert [field.name for field in found.response.fields] == ["success", "message"]
    empty = parse_service("std_srvs/srv/Empty", "---")
    assert empty.response == MessageDefinition(name="std_srvs/srv/Empty_Response")


@each(
    ("line", "wrong"),
    [
        ("uint8", "no field and no constant"),
        ("uint8 9lives", "no field and no constant"),
        ("uint8 a b", "'b' is no uint8"),
        ("uint8 a 256", "256 is not 0..255, as uint8 is"),
        ("int8 A=-129", "-129 is not -128..127"),
        ("bool A=maybe", "'maybe' is no bool"),
        ("uint8 A=", "'' is no uint8"),
        ("float32 a one", "'one' is no float32"),
        ("uint8[] A=[1]", "a constant cannot be uint8[]"),
        ("Other A=1", "a constant cannot be Other"),
        ("Other a 1", "a demo/msg/Other has no default"),
        ("uint8[2] a [1]", "1 defaults for an array of 2"),
        ("uint8[<=1] a [1, 2]", "2 defaults for an array of 1"),
        ("uint8[] a 1", "'1' is no default of an array"),
        ("uint8[0] a", "no size of an array"),
        ("uint8[<=] a", "no size of an array"),
        ("uint8<=3 a", "only a string has a bound"),
        ('string a "b', "a quote at one end"),
        ("string<=2 a abc", "longer than 2 bytes"),
        ("wstring[] A=[1]", "a constant cannot be wstring[]"),
        ("time a", "no type that is known here"),
        ("a/b/c/D x", "no type that is known here"),
        ("uint8? a", "no type that is known here"),
        ("uint8[3][2] a", "no type that is known here"),
        ("string a[3]", "no field and no constant"),
        ("uint8[] a [1,,2]", "no default of an array"),
        ("string[] a ['b' c]", "no default of an array"),
        ("string[] a ['b', 'c]", "no default of an array"),
        (f"uint8[{2**32}] a", "no size of an array"),
        (f"uint8[{'9' * 5000}] a", "no type that is known here"),
        (f"string<={'9' * 5000} a", "no type that is known here"),
    ],
)
def test_a_line_that_cannot_be_read_is_named(line, wrong):
    with pytest.raises(LocalProtocolError) as caught:
        parse_message("demo/Wrong", f"# first\n{line}\n")
    assert str(caught.value).startswith("demo/msg/Wrong, line 2: ")
    assert wrong in str(caught.value)


def test_other_things_that_cannot_be():
    with pytest.raises(LocalProtocolError, match="demo/msg/Twice, line 2: a stands there twice"):
        parse_message("demo/Twice", "uint8 a\nuint8 a=1")
    with pytest.raises(LocalProtocolError, match="line 3: 'c' is no bool"):
        parse_service("demo/Late", "bool a\n---\nbool b c")
    for text in ("", "---\n---"):
        with pytest.raises(LocalProtocolError, match="one line ---"):
            parse_service("demo/Lines", text)
    for name in ("Alone", "a/b/c/d", "demo/9", "demo/"):
        with pytest.raises(LocalProtocolError, match="no name"):
            parse_message(name, "")
