"""Every defect that `defects.h` lists has an image of its own, and those it marks are in the images of V0 and V1."""

from __future__ import annotations

import functools
import io
import re
from pathlib import Path

from elftools.elf.elffile import ELFFile

from targets import firmware
from targets.firmware import image_names, image_path
from tests.each import each

VEHICLE = Path(firmware.__file__).parent / "vehicle_interface"
LISTED = re.findall(r"((?:// .*\n)+)#ifndef DEFECT_(\w+)\n#define DEFECT_(\w+) ", (VEHICLE / "defects.h").read_text())
OPTIONS = (VEHICLE / "vehicle_interface.mk").read_text()
VARIANTS = [name for name in image_names() if name.startswith("vehicle-")]
WHOLE = {"vehicle-v0", "vehicle-v1"} | {f"vehicle-micro-ros{which}" for which in ("", "-v0", "-v1")}


def image_of(defect):
    return f"vehicle-{defect.lower().replace('_', '-')}"


def built(variable):
    """The words of a variable of vehicle_interface.mk."""
    value = re.search(rf"^{variable} := ((?:.*\\\n)*.*)$", OPTIONS, re.MULTILINE)[1]
    return value.replace("\\\n", " ").split()


def left_out(variable):
    return set(re.search(rf"^{variable} := \$\(filter-out (.*?),", OPTIONS, re.MULTILINE)[1].split())


@functools.cache
def code_of(name):
    elf = ELFFile(io.BytesIO(image_path(name).read_bytes()))
    return elf.get_section_by_name(".text").data() + elf.get_section_by_name(".data").data()


def test_the_list_is_read_whole():
    assert len(LISTED) == (VEHICLE / "defects.h").read_text().count("#ifndef DEFECT_") > 20
    assert all(asked == defined for _text, asked, defined in LISTED)


def test_each_has_an_image():
    assert {name for _text, name, _again in LISTED} == set(built("VEHICLE_DEFECTS"))
    assert {image_of(name) for _text, name, _again in LISTED} | WHOLE == set(VARIANTS)


def test_each_says_where_it_was_published():
    assert [name for text, name, _again in LISTED if not re.search(r" \| .*(V0|V1|DOC)", text)] == []


def test_those_of_both_firmwares_are_marked():
    v0 = set(built("VEHICLE_DEFECTS")) - left_out("VEHICLE_V0")
    v1 = v0 - left_out("VEHICLE_V1") | {"FLAG_CLASH", "EMERGENCY_MANUAL"}
    assert v0 == {name for text, name, _again in LISTED if "[v0]" in text}
    assert v1 == {name for text, name, _again in LISTED if "[v1]" in text}


@each("name", VARIANTS)
def test_each_image_is_another_program(name):
    same = [other for other in ["vehicle", *VARIANTS] if other != name and code_of(other) == code_of(name)]
    assert same == []
