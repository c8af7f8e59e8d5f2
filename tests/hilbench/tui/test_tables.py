"""The pane of tables: rates in bench time, what came last, field by field, and plotted."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.bench.reported_tables import ReportedTables
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.export import EXPORTS, Selection
from hilbench.tui.views.plots import plots_view
from hilbench.tui.views.tables import row_at, tables_view
from protocols.common.tables import Row, Table
from tests.each import each

MS = 1_000_000
S = 1000 * MS
TOPICS = ("writers", "readers", "type")


def topics(count, value):
    return {
        "clients": Table(
            columns=("client key", "session"), rows={"line1": Row(cells=("48 42 00 02", "0x81"), count=count)}
        ),
        "topics": Table(
            columns=TOPICS,
            rows={
                "/speed": Row(cells=("1", "12", "std_msgs/msg/Float32"), count=count, last={"data": value}),
                "/vehicle/status/velocity_status": Row(
                    cells=("1", "0", "demo/msg/Velocity"),
                    count=2 * count,
                    last={"gone_m": 2 * value, "on": count % 2 == 0, "frame": "base"},
                ),
                "/arm": Row(cells=("0", "1", "demo/msg/Arm"), count=3, last="4 bytes; demo/msg/Arm is not known here"),
                "/quiet": Row(cells=("0", "1", "std_msgs/msg/Bool"), count=0),
            },
        ),
        "actions": Table(columns=("goals",)),
    }


class Told:
    """A bench whose device tells tables, ten times a second, and the model that hears of it."""

    def __init__(self, looks, *, live=None):
        self.bench = Bench(Scheduler(), Journal())
        self.now = 0
        self.bench.tables["agent"] = lambda: looks(self.now)
        self.events = []
        self.bench.journal.on_event = self.events.append
        self.reported = ReportedTables(self.bench)
        self.model = BenchModel({"live": live or {}})

    def run(self, turns):
        for _ in range(turns):
            before = len(self.events)
            self.reported.report(whole=self.now % 50 == 0)
            self.model.take(self.events[before:])
            self.bench.run_for(0.1)
            self.now += 1
        return self.model


@pytest.fixture
def told():
    return Told(lambda now: topics(now, now / 4))


def test_only_what_has_changed_is_told_and_all_of_it_every_five_seconds(told):
    told.run(2)
    first, _, _, *then = told.events
    assert (first["table"], first["whole"], first["rows"]) == (
        "clients",
        True,
        {"line1": [["48 42 00 02", "0x81"], 0, ""]},
    )
    assert [(one["table"], one["whole"], [*one["rows"]], one["gone"]) for one in then] == [
        ("clients", False, ["line1"], []),
        ("topics", False, ["/speed", "/vehicle/status/velocity_status"], []),
    ]
    told.run(49)
    assert [one["whole"] for one in told.events[-3:]] == [True, True, True]
    assert len(told.events[-2]["rows"]) == 4


def test_who_comes_late_knows_all_after_five_seconds(told):
    told.run(45)
    late = BenchModel({"live": {}})
    before = len(told.events)
    told.run(10)
    late.take(told.events[before:])
    assert [row.key for _, row in late.tables.rows] == [row.key for _, row in told.model.tables.rows]


@each("whole", [False, True])
def test_rows_that_are_gone_are_gone(whole):
    here = {"topics": Table(columns=TOPICS, rows={name: Row(cells=("1",) * 3) for name in ("/a", "/b")})}
    less = {"topics": Table(columns=TOPICS, rows={"/b": Row(cells=("1",) * 3)})}
    told = Told(lambda now: here if now < (50 if whole else 30) else less)
    assert [row.key for _, row in told.run(30).tables.rows] == ["/a", "/b"]
    assert [row.key for _, row in told.run(21).tables.rows] == ["/b"]


def test_rates_are_of_bench_time_and_what_is_repeated_is_no_new_value(told):
    model = told.run(60)
    rows = {row.key: row for _, row in model.tables.rows}
    assert rows["/speed"].per_s(model.ns) == pytest.approx(10.0)
    assert rows["/vehicle/status/velocity_status"].per_s(model.ns) == pytest.approx(20.0)
    assert (rows["/arm"].per_s(model.ns), rows["/arm"].ns) == (0.0, 0)
    assert rows["/quiet"].ns is None
    assert len(rows["/speed"].series("data")) == 60
    assert rows["/speed"].series("data")[-1] == (5900 * MS, 59 / 4)


def test_what_is_said_anew_is_a_new_value_whatever_is_counted():
    """Of an action goals are counted, and feedback is said."""
    rows = [Row(count=1, last={"gone_m": now // 2 / 10}) for now in range(60)]
    model = Told(lambda now: {"actions": Table(rows={"/walk": rows[now]})}).run(60)
    ((_, row),) = model.tables.rows
    assert [number for _, number in row.series("gone_m")] == [now / 10 for now in range(30)]


def test_a_device_that_begins_anew_counts_anew():
    told = Told(lambda now: topics(now if now < 30 else now - 30, 1.0))
    model = told.run(30)
    assert model.tables.tables["agent", "topics"].rows["/speed"].per_s(model.ns) == pytest.approx(10.0)
    model = told.run(20)
    assert model.tables.tables["agent", "topics"].rows["/speed"].per_s(model.ns) == pytest.approx(10.0)


@pytest.mark.parametrize("size", [(38, 9), (76, 14), (130, 14)])
def test_the_tables_look_as_they_did(told, expect, size):
    model = told.run(60)
    width, height = size
    lines = tables_view(model.tables.shown, width, height, model.ns, chosen=("agent", "topics", "/arm"))
    assert max(line.cell_len for line in lines) <= width
    expect(f"tables-{width}", [line.plain for line in lines])


def test_what_stands_in_a_line_is_known_where_there_is_not_room_for_all(told):
    model = told.run(10)
    for chosen in (None, ("agent", "topics", "/quiet")):
        lines = tables_view(model.tables.shown, 60, 4, model.ns, chosen=chosen)
        found = [row_at(model.tables.shown, 4, chosen, number) for number in range(6)]
        for line, name in zip(lines, found, strict=False):
            key = line.plain[2:].split()[0]
            assert key in ("clients", "topics") if name is None else name[2].endswith(key.removeprefix("…"))
    assert found == [("agent", "topics", "/speed"), *found[1:3], ("agent", "topics", "/quiet"), None, None]


def test_two_devices_are_told_apart(told):
    told.bench.tables["other"] = told.bench.tables["agent"]
    model = told.run(5)
    assert "other topics" in "\n".join(line.plain for line in tables_view(model.tables.shown, 80, 40, model.ns))
    assert model.signals.signal("/speed data") is None
    assert model.signals.signal("other /speed data").parts[0][-1] == (400 * MS, 1.0)


def test_a_number_is_a_figure_that_can_be_plotted_and_exported(told):
    model = told.run(60)
    signal = model.signals.signal("/vehicle/status/velocity_status gone_m")
    assert (signal.unit, signal.parts[0][-1]) == ("m", (5900 * MS, 29.5))
    assert model.signals.signal("/vehicle/status/velocity_status frame").parts == []
    assert model.signals.signal("/none data") is None
    (head, *_) = plots_view(model.signals, 40, 8, model.ns, chosen=["/vehicle/status/velocity_status gone_m"])
    assert head.plain == "…ity_status gone_m 29.5 m   0.00 to 29.5"
    selection = Selection(model=model, frames=(), signals=["/speed data"], span_s=1, checks=model.checks)
    points = list(EXPORTS["plot"][1](selection))
    assert points[-1] == {"time_s": 5.9, "signal": "/speed data", "part": 1, "value": 14.75, "unit": ""}


def test_a_row_is_opened_and_a_field_of_it_plotted(told, journal_file, process_of, on_screen, rows, settle):
    told.run(60)
    process = process_of("pioneer")
    process.journal = journal_file(told.events)

    async def scenario(app, pilot):
        await pilot.press("B", "down", "down", "down", "enter")
        await settle(app, pilot)
        screen = "\n".join(rows(app))
        assert "/vehicle/status/velocity_status  writers 1, readers 0, type demo/msg/Velocity, 118x, 20.0/s" in screen
        await pilot.press("enter")
        await settle(app, pilot)
        assert "▸● gone" in "\n".join(rows(app))
        assert app.query_one("#plots").plotted[0] == "/vehicle/status/velocity_status gone_m"
        await pilot.press("down", "down", "enter", "escape")
        assert len(app.query_one("#plots").plotted) == 1 + len(app.model.signals.usual())
        await pilot.click("#tables", offset=(6, 6))
        await pilot.click("#tables", offset=(6, 6))
        await settle(app, pilot)
        assert "4 bytes; demo/msg/Arm is not known here" in "\n".join(rows(app))
        assert "no fields to show" in "\n".join(rows(app))

    on_screen(process, scenario, (160, 50))
