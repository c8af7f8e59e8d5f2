"""Bench files: what is read, what is refused, and in which words."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.benchfile.bench_schema import bench_schema
from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.files.built_in import built_in_benches
from hilbench.strict.schema import DATA_FOLDER, schema_text
from hilbench.strict.toml_lines import find_line
from protocols.p2os import ServerOptions, WrongOrder
from targets.robots.pioneer import server_options
from worlds import default_physics

TARGET = 'version = 1\n[targets.robot]\nmodel = "pioneer-2dx"\n'


@pytest.fixture
def read(tmp_path):
    def open_text(text):
        file = tmp_path / "my.toml"
        file.write_text(text)
        return open_bench(str(file))

    return open_text


def test_built_in_benches_are_right():
    assert "pioneer" in built_in_benches()
    for name in built_in_benches():
        assert open_bench(name).name == name


def test_a_whole_file(read):
    bench = read(
        """\
version = 1
[world]
scene = "corridor"
physics = "plane"
step_hz = 480
[targets.r2]
model = "pioneer-2dx"
[targets.r2.settings]
watchdog_ms = 1000
sonar_discs = [0, 7]
[[links]]
ends = ["r2.host", "peer"]
baud = 38400
"""
    )
    assert (bench.name, bench.world.scene, bench.world.physics, bench.world.step_hz) == (
        "my.toml",
        "corridor",
        "plane",
        480,
    )
    assert bench.targets["r2"].settings.watchdog_ms == 1000
    assert bench.targets["r2"].settings.sonar_discs == (0, 7)
    assert (bench.links[0].ends, bench.links[0].baud) == (("r2.host", "peer"), 38400)


def test_what_is_left_out_has_defaults(read):
    bench = read(TARGET)
    assert (bench.world.scene, bench.world.physics, bench.world.step_hz, bench.links) == (
        "empty",
        default_physics(),
        240,
        (),
    )


def test_the_digest_is_that_of_the_bytes(read):
    import hashlib

    assert read(TARGET).digest == hashlib.sha256(TARGET.encode()).hexdigest()


def test_a_scene_file_is_looked_for_beside_the_bench_file(read, tmp_path):
    (tmp_path / "hall.toml").write_text('name = "hall"\n')
    assert read(TARGET + '[world]\nscene = "hall.toml"\n').world.scene == str(tmp_path / "hall.toml")


def test_a_wrong_scene_file_is_a_wrong_bench_file(read, tmp_path):
    (tmp_path / "hall.toml").write_text('name = "hall"\nboxs = 1\n')
    with pytest.raises(UsageError, match=r"hall\.toml: .*boxs"):
        read(TARGET + '[world]\nscene = "hall.toml"\n')


def test_the_bench_in_the_working_folder_is_the_default(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert open_bench().name == "pioneer"
    (tmp_path / "hilbench.toml").write_text(TARGET)
    assert open_bench().name == "hilbench.toml"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("version = \n", 1, "is not TOML: Invalid value"),
        (TARGET + "version = 1\n[targets.robot]\n", 5, "is not TOML"),
        ("wordl = 3\n" + TARGET, 1, "unknown key 'wordl'; did you mean 'world'?"),
        (TARGET + "[world]\nscen = 1\n", 5, "unknown key 'scen' in [world]; did you mean 'scene'?"),
        (
            TARGET + "[world]\nzzz = 1\n",
            5,
            "unknown key 'zzz' in [world]; known keys: scene, vehicle, physics, step_hz",
        ),
        (TARGET + "world.scen = 1\n", 4, "unknown key 'world' in [targets.robot]; "),
        (TARGET + "settings = { watchdg_ms = 1 }\n", 4, "did you mean 'watchdog_ms'?"),
        (TARGET + "settings.watchdog_ms = 1.5\n", 4, "must be a whole number, not a number"),
        (TARGET + "settings.watchdog_ms = -1\n", 4, "watchdog_ms must be positive, not -1"),
        (TARGET + "settings.bumpers_fitted = 1\n", 4, "must be true or false, not a whole number"),
        (TARGET + "[world]\nscene = 3\n", 5, "'world.scene': must be a text, not a whole number"),
        (TARGET + "[world]\nscene = 'coridor'\n", 5, "no scene 'coridor'; did you mean 'corridor'?"),
        (TARGET + "[world]\nscene = 'hall.toml'\n", 5, "no scene file"),
        (TARGET + "[world]\nphysics = 'bulet'\n", 5, "'bulet' is not a value it takes; did you mean 'bullet'?"),
        (TARGET + "[world]\nstep_hz = 10\n", 5, "'world.step_hz': must be a whole number >= 50"),
        (TARGET + "[world]\n\n# why\n\nstep_hz = 100000\n", 8, "must be a whole number <= 10000"),
        (TARGET.replace("pioneer", "pionere"), 3, "did you mean 'pioneer-2dx'?"),
        (TARGET.replace("model", "board"), 2, "the key 'firmware' is missing"),
        (TARGET + "[targets.b]\nmodel='pioneer-2dx'\n", 4, "'b': more than one robot is not available"),
        (TARGET.replace("= 1", "= 2"), 1, "'version': 2 is not a value it takes; it takes: 1"),
        ("version = 1\n[targets]\n", 2, "names no target; add [targets.robot]"),
        (TARGET.replace("version = 1\n", ""), None, "the key 'version' is missing"),
        ("version = 1\n[targets.robot]\n", 2, "the key 'model' or 'board' is missing"),
        (TARGET + "[[links]]\nends = ['peer']\n", 5, "length 2, not 1"),
        (TARGET + "[[links]]\nends = ['peer', 'robot.hots']\n", 5, "did you mean 'robot.host'?"),
        (TARGET + "[[links]]\nends = ['peer', 'peer']\n", 5, "both ends are 'peer'"),
        (TARGET + "[[links]]\nends=['peer','robot.host']\nbaud = 14400\n", 6, "14400 is not a value it takes"),
        (TARGET + 2 * "[[links]]\nends=['peer','robot.host']\n", 6, "a second link"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(read, tmp_path, text, line, message):
    with pytest.raises(UsageError) as raised:
        read(text)
    said = str(raised.value)
    place = f"{tmp_path / 'my.toml'}:{line}: " if line else f"{tmp_path / 'my.toml'}: "
    assert said.startswith(place)
    assert message in said
    assert "\n" not in said


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("battery_dv", "300", "must be between 0 and 255, not 300"),
        ("digital_in", "300", "must be between 0 and 255, not 300"),
        ("digital_out", "-1", "must be between 0 and 255, not -1"),
        ("watchdog_ms", "70000", "must be between 0 and 65535, not 70000"),
        ("sip_cycle_ms", "300", "must be between 0 and 255, not 300"),
        ("stall_pwm", "70000", "must be between 0 and 65535, not 70000"),
        ("pid_gains", "[1, 2, 70000, 4, 5, 6]", "must be between 0 and 65535, not 70000"),
        ("analog", "[0, 0, 1023, 1024, 0]", "must be between 0 and 1023, not 1024"),
        ("translation_top_mm_s", "70000", "must be between 0 and 65535, not 70000"),
        ("translation_max_mm_s", "inf", "must be between 0 and 65535, not inf"),
        ("servo_gain_per_s", "inf", "must be finite, not inf"),
        ("track_error", "nan", "must be between -0.5 and 0.5, not nan"),
        ("front_bumper_segments", "9", "must be between 0 and 7, not 9"),
        ("sonar_discs", "[32]", "must be between 0 and 31, not 32"),
        ("host_baud", "14400", "must be one of 9600, 19200, 38400, 57600, 115200, not 14400"),
        ("serial", '"x€"', "must have at most 19 ASCII characters and no NUL"),
        ("serial", '"a\\u0000b"', "must have at most 19 ASCII characters and no NUL"),
        ("serial", f'"{"x" * 120}"', "must have at most 19 ASCII characters and no NUL"),
        ("name", '"twenty characters ..."', "must have at most 19 ASCII characters and no NUL"),
        ("sonar_discs", "[0, 16]", "14, 15 on a p2dx, not 16"),
        ("subclass", '"p9zz"', "must be one of p2dx,"),
        ("handshake_limit_s", "0", "must be between 0.001 and 3600, not 0"),
        ("max_count", "201", "201 is not a value it takes"),
        ("wrong_order", '"adpot"', "did you mean 'adopt'?"),
    ],
)
def test_a_setting_that_no_packet_can_carry(tmp_path, capsys, key, value, message):
    file = tmp_path / "my.toml"
    file.write_text(f"{TARGET}[targets.robot.settings]\nhas_move = true\n{key} = {value}\n", encoding="utf-8")
    assert main(["validate", str(file)]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert said.startswith(f"hilbench: {file}:6: ")
    assert key in said
    assert message in said
    assert said.count("\n") == 1


def test_how_the_robot_serves_can_be_said(read):
    keys = 'wrong_order = "ignore"\nmax_count = 249\nhandshake_limit_s = 10\nraw_tty = false\nwatchdog_stops = false\n'
    options = server_options(read(f"{TARGET}[targets.robot.settings]\n{keys}").targets["robot"].settings)
    assert (options.wrong_order, options.max_count) == (WrongOrder.IGNORE, 249)
    assert (options.handshake_limit_s, options.raw_tty, options.watchdog_s) == (10, False, None)


def test_a_robot_serves_by_default_as_the_protocol_does(read):
    settings = read(TARGET).targets["robot"].settings
    options = server_options(settings)
    assert options == ServerOptions(identification=options.identification)


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"version = '\xe9'\n")
    (tmp_path / "program.elf").write_bytes(b"\x7fELF\x01\x01")
    for name, message in (
        ("none.toml", "no such bench file"),
        ("latin.toml", "is not UTF-8"),
        ("program.elf", "is firmware, and no bench file"),
        (".", "cannot be read"),
    ):
        with pytest.raises(UsageError, match=message):
            open_bench(f"{tmp_path}/{name}")
    with pytest.raises(UsageError, match=r"^pionere: no such bench; did you mean 'pioneer'\?$"):
        open_bench("pionere")


def test_the_published_schema_is_that_of_the_model():
    published = (DATA_FOLDER / "bench.schema.json").read_text(encoding="utf-8")
    assert published == schema_text(bench_schema()), (
        "write schema_text(bench_schema()) to hilbench/data/bench.schema.json"
    )


def test_every_key_is_explained_in_the_schema():
    for definition in bench_schema()["$defs"].values():
        for key, entry in definition["properties"].items():
            assert entry.get("description") or "$ref" in entry, f"{definition['title']}.{key}"


values = st.sampled_from(
    [
        "1",
        '"# = [x]"',
        "'it = [''",
        '"""\n[not]\na = 1\n"""',
        "'''\nb = 2\n'''",
        "[\n 1, # ]\n 2\n]",
        '{ a = "}", b = 2 }',
    ]
)
names = st.sampled_from(["a", "b", "c-d", '"e.f"', "'g h'"])


@given(st.lists(st.tuples(st.booleans(), st.lists(names, min_size=1, max_size=3), names, values), max_size=6))
def test_a_key_is_found_where_it_was_written(tables):
    text, counts, where = "", {}, []
    for repeated, header, key, value in tables:
        dotted = ".".join(header)
        if any(
            known != dotted and (known.startswith(f"{dotted}.") or dotted.startswith(f"{known}.")) for known in counts
        ):
            continue  # what a table inside an array of tables means has a test of its own
        if dotted in counts and (not repeated or not counts[dotted][0]):
            continue
        number = counts.get(dotted, (repeated, -1))[1] + 1
        counts[dotted] = (repeated, number)
        text += f"[[{dotted}]]\n" if repeated else f"[{dotted}]\n"
        path = [part.strip("\"'") for part in header] + ([number] if repeated else [])
        where.append(((*path, key.strip("\"'")), text.count("\n") + 1))
        text += f"{key} = {value.replace(chr(39) * 2, chr(39))}\n"
    for path, line in where:
        assert find_line(text, path) == line


def test_tables_inside_an_array_of_tables_belong_to_its_last_entry():
    text = "[[a]]\n[a.b]\nc = 1\n[[a]]\n[a.b]\nc = 1\nd.e = 2\n"
    assert find_line(text, ("a", 0, "b", "c")) == 3
    assert find_line(text, ("a", 1, "b", "c")) == 6
    assert find_line(text, ("a", 1, "b", "d", "e", "unknown")) == 7
    assert find_line(text, ("zzz",)) is None
