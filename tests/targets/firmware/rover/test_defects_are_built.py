"""Every defect that `defects.h` lists has an image of its own, and those it marks are in the image of G2."""

from __future__ import annotations

import functools
import io
import re
from pathlib import Path

from elftools.elf.elffile import ELFFile

from targets import firmware
from targets.firmware import image_names, image_path
from tests.each import each

ROVER = Path(firmware.__file__).parent / "rover"
LISTED = re.findall(r"((?:// .*\n)+)#ifndef DEFECT_(\w+)\n#define DEFECT_(\w+) ", (ROVER / "defects.h").read_text())
OPTIONS = (ROVER / "rover.mk").read_text()
VARIANTS = [name for name in image_names() if name.startswith("rover-")]


def image_of(defect):
    return f"rover-{defect.lower().replace('_', '-')}"


def built(variable):
    """The words of a variable of rover.mk."""
    value = re.search(rf"^{variable} := ((?:.*\\\n)*.*)$", OPTIONS, re.MULTILINE)[1]
    return value.replace("\\\n", " ").split()


@functools.cache
def code_of(name):
    elf = ELFFile(io.BytesIO(image_path(name).read_bytes()))
    return elf.get_section_by_name(".text").data() + elf.get_section_by_name(".data").data()


def test_the_list_is_read_whole():
    assert len(LISTED) == (ROVER / "defects.h").read_text().count("#ifndef DEFECT_") > 25
    assert all(asked == defined for _text, asked, defined in LISTED)


def test_each_has_an_image():
    assert {name for _text, name, _again in LISTED} == set(built("ROVER_DEFECTS"))
    assert {image_of(name) for _text, name, _again in LISTED} <= set(VARIANTS)


def test_each_says_where_it_was_published():
    assert [name for text, name, _again in LISTED if not re.search(r" \| .*(G0|G1|G2|all|same)", text)] == []


def test_those_of_g2_are_marked():
    left_out = set(re.search(r"^ROVER_G2 := \$\(filter-out (.*),", OPTIONS, re.MULTILINE)[1].split())
    marked = {name for text, name, _again in LISTED if "[g2]" in text and "Not [g2]" not in text}
    assert marked == set(built("ROVER_DEFECTS")) - left_out


@each("name", VARIANTS)
def test_each_image_is_another_program(name):
    same = [other for other in ["rover", *VARIANTS] if other != name and code_of(other) == code_of(name)]
    assert same == []
