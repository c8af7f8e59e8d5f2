"""What holds for any two recordings."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.diff.capture import Capture, Track
from hilbench.diff.compare import Options, compare

ORDER = Options(order_only=True)


@st.composite
def captures(draw, *, least=1):
    """Three pins that change now and then, never two at a time."""
    steps = draw(st.lists(st.tuples(st.sampled_from("abc"), st.integers(1, 1000)), min_size=least, max_size=30))
    happened, ns = {name: [] for name in "abc"}, 0
    for name, wait_ns in steps:
        ns += wait_ns
        happened[name].append(ns)
    return capture(happened, ns + 1000)


def capture(happened, end_ns):
    tracks = {
        name: Track(name=name, times_ns=times, values=[bool(at % 2) for at in range(len(times))])
        for name, times in happened.items()
    }
    return Capture(label="x", kind="test", tracks=tracks, end_ns=end_ns, floats=True)


def warped(one, warp):
    times = {name: [warp(ns) for ns in track.times_ns] for name, track in one.tracks.items()}
    return capture(times, warp(one.end_ns))


@given(captures(), st.integers(0, 10**9))
def test_a_recording_is_equal_to_itself_whenever_it_was_made(one, later_ns):
    comparison = compare(one, warped(one, lambda ns: ns + later_ns), Options())
    assert comparison.first is None
    assert all(signal.equal == len(one.tracks[signal.name]) for signal in comparison.signals)
    assert comparison.anchor.late_ns == later_ns


@given(captures(), st.integers(2, 7))
def test_the_order_does_not_depend_on_how_fast_it_goes(one, factor):
    slow = warped(one, lambda ns: ns * factor)
    assert compare(one, slow, ORDER).first is None or one.end_ns < slow.end_ns
    longer = Capture(label="x", kind="test", tracks=one.tracks, end_ns=slow.end_ns, floats=True)
    assert compare(longer, slow, ORDER).first is None


@given(captures(), captures(), st.integers(0, 2000), st.booleans())
def test_who_comes_first_does_not_matter(one, other, tolerance_ns, order_only):
    options = Options(tolerance_ns=tolerance_ns, order_only=order_only)
    there, back = compare(one, other, options), compare(other, one, options)
    assert (there.first is None) == (back.first is None)
    assert [signal.equal for signal in there.signals] == [signal.equal for signal in back.signals]
    if there.first is not None and "order" not in {there.first.kind, back.first.kind}:
        assert there.first.change.signal == back.first.change.signal
        assert there.first.change.at_ns == back.first.change.at_ns


@given(captures(least=4), st.data())
def test_a_change_that_is_gone_is_found(one, data):
    name = data.draw(st.sampled_from([name for name, track in one.tracks.items() if len(track)]))
    gone = data.draw(st.integers(0, len(one.tracks[name]) - 1))
    less = {
        each: [ns for at, ns in enumerate(track.times_ns) if (each, at) != (name, gone)]
        for each, track in one.tracks.items()
    }
    assert compare(one, capture(less, one.end_ns), ORDER).first is not None
    assert compare(one, capture(less, one.end_ns), Options()).first is not None


@given(captures(least=2), st.data())
def test_a_recording_that_is_cut_is_never_equal_to_the_whole_one_unless_that_is_asked_for(one, data):
    every = sorted(ns for track in one.tracks.values() for ns in track.times_ns)
    end_ns = data.draw(st.integers(every[0], every[-1] - 1))
    cut = capture({name: track.until(end_ns).times_ns for name, track in one.tracks.items()}, end_ns)
    assert compare(one, cut, Options()).first.kind == "end"
    assert compare(one, cut, ORDER).first.kind == "end"
    assert compare(one, cut, Options(common=True)).first is None
    assert compare(cut, one, Options(until_ns=end_ns - every[0])).first is None
