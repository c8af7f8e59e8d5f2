"""The images can be found, and tell nothing of the machine they were built on."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile

from targets import firmware
from targets.firmware import image_names, image_path
from tests.each import each

ONE_OF_EACH_KIND = {name.partition("-")[0]: name for name in image_names()}.values()
SELFTESTS = [name for name in image_names() if name.startswith("selftest-")]


def test_every_image_is_found_by_its_name():
    for name in image_names():
        assert image_path(name).name == f"{name}.elf"


def test_other_formats_are_found_by_their_ending():
    assert image_path("boot-combined.hex").suffix == ".hex"
    assert image_path("boot-combined.bin").suffix == ".bin"


def test_a_missing_image_is_said_with_those_there_are():
    with pytest.raises(FileNotFoundError, match="selftest-crc"):
        image_path("selftest-nothing")


def test_every_self_test_has_an_image():
    sources = (Path(firmware.__file__).parent / "selftest").glob("*.c")
    assert sorted(f"selftest-{source.stem}" for source in sources) == SELFTESTS


@each("name", ONE_OF_EACH_KIND)
def test_functions_and_lines_can_be_looked_up(name):
    check_symbols(name)


@pytest.mark.exhaustive("every image; the gate has one of each kind")
def test_functions_and_lines_of_any_image_can_be_looked_up():
    for name in image_names():
        check_symbols(name)


def check_symbols(name):
    elf = ELFFile(io.BytesIO(image_path(name).read_bytes()))
    assert elf.get_section_by_name(".symtab").get_symbol_by_name("main"), name
    units = list(elf.get_dwarf_info().iter_CUs())
    tops = [unit.get_top_DIE().attributes for unit in units]
    folders = {top["DW_AT_comp_dir"].value.decode() for top in tops}
    # libgcc's is the distribution's
    assert all(folder == "." or folder.endswith("/libgcc") for folder in folders), name
    sources = {top["DW_AT_name"].value.decode() for top in tops if top["DW_AT_comp_dir"].value == b"."}
    assert sources & {
        "common/startup.c",
        "f103e/startup.c",
        "f767/startup.c",
        "h753/startup.c",
        "rover/startup.c",
        "style/opencm3/vector.c",
        "vehicle_interface/startup.c",
    }, name
    assert not any(source.startswith("/") for source in sources), name
