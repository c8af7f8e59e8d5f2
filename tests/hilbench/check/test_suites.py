"""Where suites are found: a file or a folder of the package, and whatever a user names."""

from __future__ import annotations

from importlib import import_module

from hilbench.benchfile.suites import SHIPPED_FOLDER, find_suites, is_shipped, shipped_suites, suite_name
from tests.each import each


@each(("name", "path"), shipped_suites().items())
def test_a_shipped_suite_is_a_file_or_a_folder_of_files(name, path):
    files = find_suites([name])
    assert files
    assert all(file.is_file() and not file.name.startswith("_") for file in files)
    assert {suite_name(file) for file in files} == {name} == {suite_name(path)}
    assert all(map(is_shipped, files))
    assert (len(files) > 1) is path.is_dir()


@each("name", [name for name, path in shipped_suites().items() if path.is_dir()])
def test_the_files_of_a_folder_run_as_its_order_says(name):
    order = getattr(import_module(f"hilbench.suites.{shipped_suites()[name].name}"), "ORDER", None)
    stems = [file.stem for file in find_suites([name])]
    assert stems == (sorted(stems) if order is None else list(order)), "a file is not named, or a name is of no file"


def test_all_shipped_suites_are_found_where_none_is_named():
    everything = find_suites([])
    assert {suite_name(file) for file in everything} == {*shipped_suites()}
    assert len(set(everything)) == len(everything)
    assert "vehicle-board" in shipped_suites()
    assert not any(path.name.startswith((".", "_")) for path in shipped_suites().values())


def test_a_folder_of_a_user_holds_one_suite_for_each_file(tmp_path):
    folder = tmp_path / "lights"
    folder.mkdir()
    file = folder / "test_lamp.py"
    file.touch()
    assert find_suites([str(folder), str(folder)]) == [folder]
    assert suite_name(file) == "lamp"
    assert not is_shipped(file)


def test_a_suite_and_its_folder_are_the_same():
    folder = SHIPPED_FOLDER / "vehicle_board"
    assert find_suites(["vehicle-board", str(folder)]) == find_suites(["vehicle-board"])
