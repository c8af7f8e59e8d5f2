"""The library is the one of the sources, and Python lays structs out as C does."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile

from targets.mcu.core import library, sources
from targets.mcu.core.library import Row
from targets.mcu.errors import EngineError
from tests.each import each

U32 = b"uint32_t"


def test_it_is_loaded_once_and_says_what_it_is():
    loaded = library.load()
    about = library.about()
    assert loaded is library.load()
    assert about.path in sources.places(about.digest)
    assert about.digest == sources.digest_of()
    assert about.compiler.partition(" ")[0] in {"gcc", "clang"}


def test_only_what_is_meant_to_be_is_exported():
    with library.about().path.open("rb") as file:
        symbols = ELFFile(file).get_section_by_name(".dynsym").iter_symbols()
        exported = {one.name for one in symbols if one["st_shndx"] != "SHN_UNDEF"}
    assert {"hil_compiler", "hil_layout", "hil_sources_digest"} <= exported
    assert {name for name in exported if not name.startswith("hil_")} <= {"_init", "_fini"}


def test_loading_it_starts_no_process_and_needs_nothing_to_build_with():
    loading = "import sys; from targets.mcu.core.library import load; load(); print(*sys.modules)"
    root = Path(sources.__file__).parents[3]
    done = subprocess.run([sys.executable, "-S", "-c", loading], cwd=root, check=True, capture_output=True, text=True)
    assert not {"subprocess", "tempfile", "targets.mcu.core.build"} & {*done.stdout.split()}


def test_the_structs_of_the_library_are_those_of_its_own_table():
    made = library.structure("hil_row")
    assert ctypes.sizeof(made) == ctypes.sizeof(Row)
    assert [name for name, _ in made._fields_] == [name for name, _ in Row._fields_]
    assert all(getattr(made, name).offset == getattr(Row, name).offset for name, _ in Row._fields_)
    with pytest.raises(AttributeError):
        made().no_such_field = 1
    with pytest.raises(KeyError):
        library.structure("no_such_struct")


def test_arrays_pointers_and_structs_in_structs():
    rows = [
        Row(b"inner", b"", b"", 0, 8, 0),
        Row(b"inner", b"at", U32, 0, 4, 0),
        Row(b"inner", b"kind", b"uint8_t", 4, 1, 0),
        Row(b"outer", b"", b"", 0, 40, 0),
        Row(b"outer", b"cycles", b"uint64_t", 0, 8, 0),
        Row(b"outer", b"handle", b"void *", 8, 8, 0),
        Row(b"outer", b"all", b"struct inner", 16, 24, 3),
    ]
    made = library.structures_of(rows)
    outer = made["outer"](cycles=1 << 40)
    outer.all[2].kind = 7
    assert bytes(outer)[36] == 7
    assert made["inner"].from_buffer_copy(outer, 32).kind == 7


@each(
    ("rows", "says"),
    [
        ([Row(b"a", b"", b"", 0, 8, 0), Row(b"a", b"x", U32, 4, 4, 0)], "a.x has 4 bytes at 4 in C, 4 at 0 in Python"),
        ([Row(b"a", b"", b"", 0, 8, 0), Row(b"a", b"x", U32, 0, 8, 0)], "a.x has 8 bytes at 0 in C, 4 at 0 in Python"),
        ([Row(b"a", b"", b"", 0, 64, 0), Row(b"a", b"x", U32, 0, 4, 0)], "a has 64 bytes in C, 4 in Python"),
        (
            [Row(b"a", b"", b"", 0, 8, 0), Row(b"a", b"x", b"long", 0, 8, 0)],
            "a.x has the type 'long', which is none of",
        ),
    ],
)
def test_a_struct_that_python_would_see_otherwise_is_refused(rows, says):
    with pytest.raises(EngineError, match=says) as refused:
        library.structures_of(rows)
    assert refused.value.hint.endswith("-m targets.mcu.core.build")


def test_a_file_that_is_no_library_is_named_with_what_to_do(tmp_path):
    file = tmp_path / "libhilmcu.so"
    file.write_bytes(b"\x7fELF, not really")
    with pytest.raises(EngineError, match="cannot be loaded") as refused:
        library.open_library(file, sources.digest_of())
    assert refused.value.where == str(file)
    assert refused.value.hint.startswith("remove it, then: ")


def test_a_library_of_other_sources_is_refused():
    with pytest.raises(EngineError, match="is of other sources"):
        library.open_library(library.about().path, "0" * 64)
