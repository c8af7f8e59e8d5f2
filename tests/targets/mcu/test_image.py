"""Images: ELF, Intel HEX and BIN, behind boot loaders, and everything that can be wrong with them."""

from __future__ import annotations

import contextlib
import hashlib
import io
import shutil
import struct
import subprocess

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from intelhex import IntelHex

from targets.firmware import image_path
from targets.mcu.errors import ImageError
from targets.mcu.image import limits_for, load_image
from tests.each import each
from tests.share import examples

CHIP = limits_for("STM32F103C8")
FLASH = 0x0800_0000
LOOP = b"\xfe\xe7"
HANDLER_AT = 0x100  # offset of `b .` in the firmware below
RESET_AT = 0x104


def firmware(base=FLASH, stack=0x2000_5000, reset=None, size=0x140):
    """A vector table whose handlers are all `b .`, and a reset handler."""
    reset = base + RESET_AT + 1 if reset is None else reset
    table = struct.pack("<59I", stack, reset, *[base + HANDLER_AT + 1] * 57)
    return (table.ljust(HANDLER_AT, b"\0") + LOOP + b"\0\0" + b"\x00\xbf" + LOOP).ljust(size, b"\x11")


def elf_file(
    pieces,
    *,
    symbols=(),
    machine=40,
    kind=2,
    entry=FLASH + RESET_AT + 1,
    bits=1,
    endian=1,
    profile=b"M",
    arch=10,
):
    """An ELF file with one segment for each (virtual address, physical address, data, bytes in memory)."""
    names = b"\0.symtab\0.strtab\0.shstrtab\0.text\0.ARM.attributes\0"
    body, phdrs, shdrs = bytearray(), [], [bytes(40)]
    at = 52 + 32 * len(pieces)
    for virtual, physical, data, in_memory in pieces:
        phdrs.append(struct.pack("<8I", 1, at + len(body), virtual, physical, len(data), in_memory, 5, 4))
        body += data
    strtab, table = b"\0", bytearray(16)
    for name, value, size, info in symbols:
        table += struct.pack("<IIIBBH", len(strtab), value, size, info, 0, 1)
        strtab += name.encode() + b"\0"
    attributes = b""
    if profile is not None:
        values = bytes((6, arch, 7)) + profile
        part = b"\x01" + struct.pack("<I", len(values) + 5) + values
        attributes = b"A" + struct.pack("<I", len(part) + 4 + 6) + b"aeabi\0" + part

    def section(name, kind, data, *, link=0, entry_size=0, flags=0, address=0):
        shdrs.append(
            struct.pack(
                "<10I", names.index(name), kind, flags, address, at + len(body), len(data), link, 1, 4, entry_size
            )
        )
        body.extend(data)

    virtual, _, data, _ = pieces[0] if pieces else (0, 0, b"", 0)
    shdrs.append(struct.pack("<10I", names.index(b".text"), 1, 6, virtual, at, len(data), 0, 0, 4, 0))
    section(b".symtab", 2, bytes(table), link=3, entry_size=16)
    section(b".strtab", 3, strtab)
    if attributes:
        section(b".ARM.attributes", 0x7000_0003, attributes)
    section(b".shstrtab", 3, names)
    header = b"\x7fELF" + bytes((bits, endian, 1)) + bytes(9)
    header += struct.pack(
        "<HHIIIIIHHHHHH",
        kind,
        machine,
        1,
        entry,
        52,
        at + len(body),
        0x0500_0200,
        52,
        32,
        len(pieces),
        40,
        len(shdrs),
        len(shdrs) - 1,
    )
    return header + b"".join(phdrs) + bytes(body) + b"".join(shdrs)


def simple_elf(base=FLASH, **options):
    data = firmware(base)
    return elf_file([(base, base, data, len(data))], entry=base + RESET_AT + 1, **options)


def hex_text(segments):
    parsed = IntelHex()
    for address, data in segments:
        parsed.frombytes(data, address)
    out = io.StringIO()
    parsed.write_hex_file(out)
    return out.getvalue()


@pytest.fixture
def save(tmp_path):
    def write(data, name="image"):
        path = tmp_path / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return path

    return write


def refused(path, chip=CHIP, **options):
    with pytest.raises(ImageError) as caught:
        load_image(path, chip, **options)
    assert caught.value.where == str(path)
    assert caught.value.hint
    return f"{caught.value} -- {caught.value.hint}"


# --- what works


def test_a_raw_image(save):
    image = load_image(save(firmware()), CHIP)
    assert (image.format, image.table, image.stack_pointer) == ("bin", FLASH, 0x2000_5000)
    assert image.reset_vector == FLASH + RESET_AT + 1
    assert image.digest == hashlib.sha256(firmware()).hexdigest()
    assert [(one.address, one.data) for one in image.segments] == [(FLASH, firmware())]
    assert image.flash_bytes == 0x140
    assert image.notes == ()
    assert image.function_at(FLASH + RESET_AT) is None


def test_an_image_is_taken_apart_again_only_when_the_file_is_another(tmp_path):
    file = tmp_path / "firmware.bin"
    file.write_bytes(firmware())
    first = load_image(file, CHIP)
    assert load_image(file, CHIP) is first
    file.write_bytes(firmware(stack=0x2000_4000))
    assert load_image(file, CHIP).stack_pointer == 0x2000_4000
    assert load_image(file, limits_for("STM32F103RB")) is not first


def test_an_intel_hex_image(save):
    text = hex_text([(FLASH, firmware()), (FLASH + 0x8000, b"settings")])
    image = load_image(save(text, "a.hex"), CHIP)
    assert image.format == "hex"
    assert [(one.address, one.data) for one in image.segments] == [
        (FLASH, firmware()),
        (FLASH + 0x8000, b"settings"),
    ]


def test_an_elf_image_puts_data_at_its_physical_address(save):
    code, data = firmware(), b"initial values!!"
    elf = elf_file([(FLASH, FLASH, code, len(code)), (0x2000_0000, FLASH + 0x140, data, 0x200)])
    image = load_image(save(elf), CHIP)
    assert [(one.address, one.data) for one in image.segments] == [(FLASH, code), (FLASH + 0x140, data)]
    assert image.format == "elf"
    assert image.ram_bytes == 0x200
    assert image.flash_bytes == 0x150


def test_headers_of_the_file_in_a_segment_are_not_loaded(save):
    """Linkers may let the first segment begin with the ELF header; only sections count."""
    elf = bytearray(simple_elf())
    at = 52 + 32
    struct.pack_into("<8I", elf, 52, 1, 0, FLASH - at, FLASH - at, at + 0x140, at + 0x140, 5, 4)
    image = load_image(save(bytes(elf)), CHIP)
    assert [(one.address, one.data) for one in image.segments] == [(FLASH, firmware())]


@pytest.mark.parametrize("offset", [0x1000, 0x2000, 0x5000, 0x8000])
def test_images_behind_a_boot_loader_find_their_table(save, offset):
    base = FLASH + offset
    files = (
        save(simple_elf(base), "a.elf"),
        save(hex_text([(base, firmware(base))]), "a.hex"),
        save(firmware(base), "a.bin"),
    )
    for path in files:
        image = load_image(path, CHIP)
        assert image.table == base, path
        assert image.segments[0].address == base
        assert f"0x{base:08X}" in " ".join(image.notes)
    assert load_image(files[2], CHIP, base=base).table == base


@pytest.mark.parametrize("offset", [0, 0x2000, 0x5000])
def test_raw_bytes_without_default_handlers_are_placed_by_their_length(save, offset):
    data = firmware(FLASH + offset).replace(LOOP, b"\x70\x47")
    assert load_image(save(data), CHIP).table == FLASH + offset


def test_raw_bytes_that_could_belong_anywhere_are_put_at_the_beginning(save):
    data = firmware(FLASH + 0x2000, size=0x4000).replace(LOOP, b"\x70\x47")
    assert load_image(save(data), CHIP).table == FLASH
    assert load_image(save(data), CHIP, base=FLASH + 0x2000).table == FLASH + 0x2000


def test_a_named_table_behind_a_boot_loader(save):
    base = FLASH + 0x2000
    data = b"header".ljust(0x200, b"\0") + firmware(base + 0x200)
    elf = elf_file(
        [(base, base, data, len(data))],
        entry=base + 0x200 + RESET_AT + 1,
        symbols=[("g_pfnVectors", base + 0x200, 0, 0x11)],
    )
    assert load_image(save(elf), CHIP).table == base + 0x200


def test_boot_loader_and_application_in_one_start_with_the_boot_loader(save):
    application = FLASH + 0x2000
    text = hex_text([(FLASH, firmware()), (application, firmware(application))])
    assert load_image(save(text), CHIP).table == FLASH


def test_option_bytes_in_a_hex_file_are_kept(save):
    image = load_image(save(hex_text([(FLASH, firmware()), (0x1FFF_F800, b"\xa5\x5a")])), CHIP)
    assert image.segments[-1].address == 0x1FFF_F800


def test_data_in_ram_is_loaded_and_said(save):
    code = firmware()
    elf = elf_file([(FLASH, FLASH, code, len(code)), (0x2000_0000, 0x2000_0000, b"1234", 4)])
    image = load_image(save(elf), CHIP)
    assert [one.address for one in image.segments] == [FLASH, 0x2000_0000]
    assert "RAM" in image.notes[0]


@pytest.mark.parametrize("stack", [0x2000_0004, 0x2000_0400, 0x2000_5000])
def test_a_stack_may_start_anywhere_in_ram_up_to_its_end(save, stack):
    assert load_image(save(firmware(stack=stack)), CHIP).stack_pointer == stack


def test_a_cortex_m4_image_is_let_through_with_a_note(save):
    assert "ARMv7E-M" in load_image(save(simple_elf(arch=13)), CHIP).notes[0]


@pytest.mark.parametrize(("wide", "said"), [((0xFB02, 0x4103), False), ((0xFB12, 0x4103), True)])  # MLA, SMLABB
def test_what_a_linker_calls_armv7e_m_is_noted_if_it_has_such_instructions(save, wide, said):
    """A library is enough for the linker; mapping symbols tell code from data."""
    data = bytearray(firmware())
    at = RESET_AT + 8
    struct.pack_into("<HHHH", data, at, *wide, 0xFB12, 0x4103)
    marks = [(name, FLASH + offset, 0, 0) for name, offset in (("$d", 0), ("$t", RESET_AT), ("$d.1", at + 4))]
    notes = load_image(save(elf_file([(FLASH, FLASH, bytes(data), len(data))], symbols=marks, arch=13)), CHIP).notes
    assert any(f"lacks the instruction at 0x{FLASH + at:08X}" in note for note in notes) is said
    assert any("ARMv7E-M" in note for note in notes) is said


# --- symbols


def test_functions_by_address(save):
    symbols = [
        ("Default_Handler", FLASH + HANDLER_AT + 1, 2, 0x02),
        ("EXTI0_IRQHandler", FLASH + HANDLER_AT + 1, 2, 0x22),
        ("Reset_Handler", FLASH + RESET_AT + 1, 0, 0x12),
        ("$t", FLASH + RESET_AT, 0, 0x00),
        ("main", FLASH + 0x120 + 1, 0x10, 0x12),
    ]
    image = load_image(save(simple_elf(symbols=symbols)), CHIP)
    names = {at: image.function_at(FLASH + at) for at in (0xFF, 0x100, 0x101, 0x102, 0x104, 0x11F, 0x120, 0x12F, 0x130)}
    assert names == {
        0xFF: None,
        0x100: "Default_Handler",
        0x101: "Default_Handler",
        0x102: None,
        0x104: "Reset_Handler",
        0x11F: "Reset_Handler",
        0x120: "main",
        0x12F: "main",
        0x130: None,
    }
    found = image.symbols.find("main")
    assert found is not None
    assert found.address == FLASH + 0x120
    assert image.symbols.find("nobody") is None
    assert image.line_at(FLASH + 0x120) is None


@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="needs arm-none-eabi-gcc")
@pytest.mark.parametrize("dwarf", [4, 5])
def test_lines_of_a_compiled_program(tmp_path, dwarf):
    source = tmp_path / "blink.c"
    source.write_text(
        "void reset(void);\n"
        "static volatile unsigned pin = 3;\n"
        "static unsigned twice(unsigned x) {\n"
        "    return x + x;\n"
        "}\n"
        '__attribute__((section(".vectors"), used))\n'
        "static void *const table[] = {(void *)0x20005000, reset};\n"
        "void reset(void) {\n"
        "    for (;;) pin = twice(pin);\n"
        "}\n"
    )
    script = tmp_path / "chip.ld"
    script.write_text(
        "SECTIONS { .text 0x08000000 : { KEEP(*(.vectors)) *(.text*) _etext = .; }"
        " .data 0x20000000 : AT(_etext) { *(.data*) } }"
    )
    out = tmp_path / "blink.elf"
    flags = ["-mcpu=cortex-m3", "-mthumb", "-O0", f"-gdwarf-{dwarf}", "-nostdlib", "-e", "reset", "-T", str(script)]
    subprocess.run(["arm-none-eabi-gcc", *flags, "-o", str(out), str(source)], check=True, cwd=tmp_path)
    image = load_image(out, CHIP)
    reset, twice = image.symbols.find("reset"), image.symbols.find("twice")
    assert reset is not None
    assert twice is not None
    assert image.reset_vector == reset.address + 1
    assert image.function_at(twice.address + 2) == "twice"
    assert image.line_at(twice.address) == "blink.c:3"
    lines = {image.line_at(pc) for pc in range(reset.address, reset.address + reset.size, 2)}
    assert lines == {"blink.c:8", "blink.c:9"}
    assert image.line_at(reset.address + reset.size + 0x100) is None


def test_functions_that_the_linker_dropped_have_no_place():
    """Their lines stay in the tables at address 0, which is where a call of a null pointer goes."""
    image = load_image(image_path("style-irq-dma"), CHIP)
    assert image.line_at(0) is None
    assert image.line_at(image.reset_vector & ~1).startswith("startup.c:")
    assert image.segments[0].address == FLASH
    assert all(one.address < FLASH + 0x1000 for one in image.segments)


# --- what does not


def test_files_that_cannot_be_read(tmp_path, save):
    assert "no such file" in refused(tmp_path / "nothing.elf")
    assert "a directory" in refused(tmp_path)
    assert "empty" in refused(save(b""))


def test_a_file_without_permission(save, monkeypatch):
    path = save(firmware())

    def deny(_self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", deny)
    assert "Permission denied" in refused(path)


def test_every_truncation_of_an_elf_is_called_that(save):
    elf = simple_elf()
    for size in range(4, len(elf), 7):
        assert "truncated" in refused(save(elf[:size])), size


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"machine": 62}, "x86-64"),
        ({"machine": 243}, "RISC-V"),
        ({"machine": 4711}, "machine 4711"),
        ({"bits": 2}, "64-bit"),
        ({"endian": 2}, "big-endian"),
        ({"kind": 1}, "not linked"),
        ({"kind": 3}, "shared library"),
        ({"profile": b"A"}, "profile A"),
        ({"profile": b"R"}, "profile R"),
    ],
)
def test_elf_files_for_something_else(save, options, text):
    assert text in refused(save(simple_elf(**options)))


def test_arm_code_for_another_profile(save):
    data = firmware()
    elf = elf_file([(FLASH, FLASH, data, len(data))], entry=FLASH + RESET_AT, profile=b"S")
    assert "ARM code" in refused(save(elf))


def test_without_attributes_the_vectors_decide_and_not_the_entry_point(save):
    data = firmware()
    elf = elf_file([(FLASH, FLASH, data, len(data))], entry=FLASH + RESET_AT, profile=None)
    assert load_image(save(elf), CHIP).reset_vector & 1


def test_an_elf_without_anything_to_load(save):
    assert "nothing to load" in refused(save(elf_file([])))


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    deadline=None,
    max_examples=examples(300),
)
@given(changes=st.lists(st.tuples(st.integers(0, 2**16), st.integers(0, 255)), min_size=1, max_size=8))
def test_a_damaged_elf_is_loaded_or_refused_and_nothing_else(save, changes):
    symbols = [("main", FLASH + 0x120 + 1, 0x10, 0x12), ("g_pfnVectors", FLASH, 0, 0x11)]
    elf = bytearray(simple_elf(symbols=symbols))
    for place, value in changes:
        elf[place % len(elf)] = value
    with contextlib.suppress(ImageError):
        load_image(save(bytes(elf)), CHIP).line_at(FLASH + 0x104)


def test_hex_files_that_were_joined(save):
    """A boot loader and its application, one text behind the other; linkers write a start address into each."""
    start, end = ":0400000508000101ED\n", ":00000001FF\n"
    loader, application = (
        hex_text([(base, firmware(base))]).replace(end, start + end) for base in (FLASH, FLASH + 0x8000)
    )
    assert len(load_image(save(loader.replace(end, "") + application, "joined.hex"), CHIP).segments) == 2
    text = refused(save(loader + application, "joined.hex"))
    assert "goes on after its end record" in text
    assert "leave out the end record of the first" in text


def test_hex_files_that_are_damaged(save):
    text = hex_text([(FLASH, firmware())])
    lines = text.splitlines()
    assert "end record" in refused(save("\n".join(lines[:-1])))
    assert "bad Intel HEX" in refused(save(text[: len(text) // 2 - 3]))
    wrong = lines[2][:-2] + f"{(int(lines[2][-2:], 16) + 1) & 0xFF:02X}"
    assert "bad Intel HEX" in refused(save("\n".join([*lines[:2], wrong, *lines[3:]])))
    assert "bad Intel HEX" in refused(save("\n".join([*lines[:-1], *lines[:3], lines[-1]])))  # twice the same address
    assert "without data" in refused(save(":00000001FF\n"))
    assert "not text" in refused(save(b":00\xff0001FF\n"))


@pytest.mark.parametrize(("start", "name"), [(b"UF2\n", "UF2"), (b"S00F", "S-record"), (b"PK\x03\x04", "ZIP")])
def test_other_formats_are_named(save, start, name):
    assert name in refused(save(start + bytes(100)))


def test_a_bin_too_short_for_a_table(save):
    assert "truncated" in refused(save(b"\0\x50\0\x20"))


@pytest.mark.parametrize("fill", [b"\xff" * 0x400, firmware()[:4] + b"\xff" * 0x200, b"\xff" * 4 + firmware()[4:]])
def test_an_erased_vector_table(save, fill):
    assert "erased (0xFFFFFFFF)" in refused(save(fill))


def test_too_much_flash_names_the_chip_that_would_fit(save):
    text = refused(save(firmware(size=70 * 1024)))
    assert "71680" in text
    assert "STM32F103C8" in text
    assert "it would fit an STM32F103CB (128 KB of flash, 20 KB of RAM)" in text
    assert "STM32F103RE" in refused(save(firmware(size=500 * 1024)))
    assert "no STM32F103" in refused(save(firmware(size=2000 * 1024)))


def test_too_much_ram(save):
    code = firmware()
    elf = elf_file([(FLASH, FLASH, code, len(code)), (0x2000_0000, FLASH + 0x140, b"", 30 * 1024)])
    text = refused(save(elf))
    assert "30720 bytes of RAM" in text
    assert "it would fit an STM32F103RC (256 KB of flash, 48 KB of RAM)" in text


@pytest.mark.parametrize(
    ("stack", "text"),
    [
        (0x2000_5004, "STM32F103RC"),
        (0x2001_0000, "STM32F103RD"),
        (0x2000_0000, "outside the RAM"),
        (0x1000_2000, "outside the RAM"),
        (0, "outside the RAM"),
        (0x2000_4FFE, "multiple of 4"),
        (0x464C_457C, "outside the RAM"),
    ],
)
def test_stack_pointers_outside_of_ram(save, stack, text):
    assert text in refused(save(firmware(stack=stack)))


@pytest.mark.parametrize(
    ("reset", "text"),
    [
        (FLASH + RESET_AT, "Thumb bit"),
        (0x2000_0101, "not in the flash"),
        (0x0801_0001, "not in the flash"),
        (0x0000_0105, "not in the flash"),
        (FLASH + 0x4001, "erased flash"),
        (0xFFFF_FFFF, "erased"),
    ],
)
def test_reset_vectors_that_lead_nowhere(save, reset, text):
    assert text in refused(save(firmware(reset=reset)))


def test_a_reset_vector_into_erased_bytes_of_the_image(save):
    data = bytearray(firmware())
    data[RESET_AT : RESET_AT + 2] = b"\xff\xff"
    assert "erased flash" in refused(save(bytes(data)))


def test_an_image_for_ram(save):
    data = firmware(0x2000_0000)
    elf = elf_file([(0x2000_0000, 0x2000_0000, data, len(data))], entry=0x2000_0105)
    assert "run from RAM" in refused(save(elf))


def test_data_where_there_is_no_memory(save):
    text = refused(save(hex_text([(FLASH, firmware()), (0x6000_0000, b"1234")])))
    assert "RAM" in text
    assert "0x00000000" in refused(save(elf_file([(0, 0, firmware(0), 0x140)], entry=RESET_AT + 1)))


def test_a_table_cut_off(save):
    assert "no vector table" in refused(save(hex_text([(FLASH, firmware()[:6])])))


@each(
    ("part", "flash_kb", "ram_kb"),
    [("STM32F103C8", 64, 20), ("stm32f103cbt6", 128, 20), ("STM32F103RET6", 512, 64), ("STM32F103C6", 32, 10)],
)
def test_limits_by_part_number(part, flash_kb, ram_kb):
    limits = limits_for(part)
    assert (limits.flash_size, limits.ram_size) == (flash_kb * 1024, ram_kb * 1024)


def test_an_unknown_part():
    with pytest.raises(KeyError):
        limits_for("STM32F407VG")


class TestF767:
    """An STM32F767ZI: flash at two addresses, RAM of the core at 0, option bytes elsewhere."""

    CHIP = limits_for("STM32F767ZIT6")
    TOP = 0x2008_0000

    @pytest.fixture
    def refused(self):
        def refused(path):
            with pytest.raises(ImageError) as caught:
                load_image(path, self.CHIP)
            return f"{caught.value} ({caught.value.hint})"

        return refused

    def test_an_image_that_takes_all_ram(self, save):
        image = load_image(save(firmware(stack=self.TOP)), self.CHIP)
        assert (image.table, image.stack_pointer, image.notes) == (FLASH, self.TOP, ())

    def test_flash_seen_through_the_itcm_interface(self, save):
        data = firmware(0x0020_0000, stack=self.TOP)
        image = load_image(save(elf_file([(0x0020_0000, 0x0020_0000, data, len(data))])), self.CHIP)
        assert (image.table, image.reset_vector, image.notes) == (FLASH, 0x0020_0000 + RESET_AT + 1, ())
        assert load_image(save(data), self.CHIP).segments[0].address == 0x0020_0000

    def test_code_that_runs_by_itcm_and_is_programmed_by_axi(self, save):
        data = firmware(stack=self.TOP, reset=0x0020_0000 + RESET_AT + 1)
        assert load_image(save(hex_text([(FLASH, data)])), self.CHIP).reset_vector == 0x0020_0000 + RESET_AT + 1

    def test_the_ram_of_the_core_takes_data_and_a_stack(self, save):
        data = firmware(stack=0x4000)
        image = load_image(save(elf_file([(FLASH, FLASH, data, len(data)), (0, 0, b"1234", 0x4000)])), self.CHIP)
        assert image.ram_bytes == 0x4000
        assert [segment.address for segment in image.segments] == [0, FLASH]
        assert "4 bytes are put into RAM at 0x00000000" in image.notes[0]

    def test_option_bytes_may_be_part_of_an_image(self, save):
        image = load_image(save(hex_text([(FLASH, firmware()), (0x1FFF_0000, bytes(32))])), self.CHIP)
        assert image.segments[-1].address == 0x1FFF_0000

    @pytest.mark.parametrize(
        ("data", "text"),
        [
            (firmware(stack=0x2008_0004), "is outside the RAM of STM32F767ZIT6 (0x20000000 to 0x20080000)"),
            (firmware(stack=0x4004), "is outside the RAM"),
            (firmware(stack=0x2000_0002), "is not a multiple of 4"),
            (firmware(stack=0xFFFF_FFFF), "the vector table at 0x08000000 is erased (0xFFFFFFFF)"),
            (firmware(reset=0x0820_0001), "is not in the flash of STM32F767ZIT6 (is this an image for an STM32F7?)"),
            (firmware(reset=0x0040_0001), "is not in the flash"),
            (firmware(reset=0x0000_0105), "is not in the flash"),
            (firmware(reset=FLASH + 0x4001), "points to erased flash"),
            (firmware(size=(2 << 20) + 1), "reaches 2097153 bytes into flash, STM32F767ZIT6 has 2097152"),
        ],
    )
    def test_what_cannot_run(self, save, refused, data, text):
        assert text in refused(save(data))

    def test_too_much_for_the_ram_of_the_core(self, save, refused):
        elf = elf_file([(FLASH, FLASH, firmware(), 0x140), (0, 0, b"1234", 0x4004)])
        assert "needs 16388 bytes of RAM from 0 on, STM32F767ZIT6 has 16384" in refused(save(elf))

    def test_what_was_built_for_its_core_needs_no_note(self, save):
        data = firmware(stack=self.TOP)
        assert load_image(save(elf_file([(FLASH, FLASH, data, len(data))], arch=13)), self.CHIP).notes == ()
        newer = load_image(save(elf_file([(FLASH, FLASH, data, len(data))], arch=17)), self.CHIP)
        assert "ARMv8-M mainline: instructions that a Cortex-M7 lacks will fault" in newer.notes[0]

    def test_its_image_on_a_smaller_chip(self, save):
        with pytest.raises(ImageError) as caught:
            load_image(save(firmware(stack=self.TOP)), CHIP)
        assert "no STM32F103 is that large; it would fit an STM32F767VG" in caught.value.hint
