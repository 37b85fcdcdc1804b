"""Walking trials as a laboratory has them: markers, plates and events in files, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.experiments.walking.analysis import analyse_walking
from tepsipe.experiments.walking.files import read_events
from tepsipe.experiments.walking.instruments import is_of_instruments, read_instruments, walking_recording
from tepsipe.experiments.walking.needed_strides import allocation
from tepsipe.experiments.walking.options import WalkingAxes, WalkingFiles, WalkingOptions, WalkingPlates
from tepsipe.experiments.walking.results import walking_estimates
from tepsipe.experiments.walking.strides import detect_events, segment_strides
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.formats import read_recording
from tepsipe.reporting.recovery import compare_phases_with_truth
from tepsipe.virtual_lab.walker import Joint, perturb
from tepsipe.virtual_lab.walking_trial import WalkerBody, write_events, write_walk
from tests.experiments.test_walking import synthetic_walk

PLATES = WalkingPlates(1, 2)
C3D = WalkingFiles(WalkingAxes("+y", "+z"), PLATES)
DFLOW = WalkingFiles(WalkingAxes("-z", "+y"), PLATES)
# D-Flow holds the position of a hidden marker: one that does not move at all is hidden
STILL = WalkerBody(marker_noise_m=2e-5, force_noise_N=0.0, moment_noise_Nm=0.0)
KINDS = {"c3d": ("walk.c3d", C3D), "dflow": ("walk.txt", DFLOW)}


@pytest.fixture(scope="module")
def walks():
    base = synthetic_walk(76)
    base.signals["other_vertical"] = base.signals["other_vertical"] + 20.0
    pulses = {k: (40.0, 80.0, 125.0)[k % 3] for k in range(3, 72, 2)}
    pulses = {k: p for k, p in pulses.items() if p < 100.0 or k < 50}
    rng = np.random.default_rng(3)
    return base, perturb(base, Joint(), pulses, np.deg2rad(2.0), 0.06, 0.0, rng)


@pytest.fixture(scope="module")
def written(walks, tmp_path_factory):
    folder = tmp_path_factory.mktemp("walks")
    for kind, (name, _) in KINDS.items():
        write_walk(folder / name, kind, walks[1], walks[0], STILL, np.random.default_rng(4))
    write_events(folder / "events.csv", walks[1])
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_files_without_noise_give_the_signals_of_the_walk(kind, walks, written):
    name, files = KINDS[kind]
    assert is_of_instruments(written / name)
    found = read_instruments(written / name, files, 100.0, 0.1)
    signals, n = walks[1].signals, found.time.size
    # plates of the C3D have five samples per frame, and are band limited on the way back
    stance = signals["vertical"][:n] > 740.0
    tolerances = {"angle": 4e-4, "ankle_x": 4e-5, "ankle_y": 4e-5, "vertical": 4.0, "cop": 5e-4}
    for own, tolerance in tolerances.items():
        difference = (getattr(found, own) - signals[own][:n])[stance]
        assert (difference - difference.mean()).std() < tolerance, own


def test_the_plantarflexion_of_a_known_posture(written):
    recording = read_recording(written / "walk.txt")
    turned = recording.markers.positions.copy()
    k = {label: i for i, label in enumerate(recording.markers.labels)}
    ankle, up, forward = turned[:, k["LMAL"]], np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])
    angle = np.deg2rad(10.0)  # knee 10 degrees behind the ankle, foot flat: plantarflexion
    turned[:, k["LKNE"]] = ankle + 0.4 * (np.cos(angle) * up - np.sin(angle) * forward)
    turned[:, k["LTOE"]] = turned[:, k["LHEE"]] + 0.2 * forward
    markers = replace(recording.markers, positions=turned)
    found = walking_recording(replace(recording, markers=markers), DFLOW, 100.0, 0.1)
    assert found.angle == pytest.approx(angle, abs=1e-4)


def test_events_by_the_force_are_those_of_the_walk(walks, written):
    found = read_instruments(written / "walk.txt", DFLOW, 100.0, 0.1)
    heel, toe = detect_events(found)
    events = read_events(written / "events.csv", dict.fromkeys(("heel_strike", "toe_off", "pulse"), None))
    assert not events["heel_strike"].size
    assert heel == pytest.approx(walks[1].heel_strikes, abs=0.02)
    assert toe[: walks[1].toe_offs.size] == pytest.approx(walks[1].toe_offs, abs=0.02)


def test_stiffness_in_stance_and_nothing_in_swing(walks, written, tmp_path):
    found = read_instruments(written / "walk.c3d", C3D, 100.0, 0.1)
    names = {name: name for name in ("heel_strike", "toe_off", "pulse")}
    events = read_events(written / "events.csv", names)
    strides = segment_strides(events["heel_strike"], events["toe_off"])
    options = WalkingOptions(control_percent=(125.0,))
    rows, contributions = walking_estimates("a", analyse_walking(found, strides, events["pulse"], options))
    ESTIMATES.write(tmp_path / "rows.csv", rows)
    rows = ESTIMATES.read(tmp_path / "rows.csv")
    swing = [row for row in rows if row.pathway == "swing-125"]
    assert [row.quantity for row in swing] == ["I", "B", "K"]
    assert all(np.isnan(row.value) and row.ci_low is None for row in swing)
    assert all(row.flags == "not-identified;no-contact" and not row.recommended for row in swing)
    percent, joint = np.arange(101.0), Joint()
    curve = {"percent": percent, "I": 0.012 + 0.0 * percent, "B": joint.damping(percent)}
    compared = compare_phases_with_truth(rows, {"a": curve | {"K": joint.stiffness(percent)}})
    of_k = [row for row in compared if row.quantity == "K"]
    assert [row.pathway for row in of_k] == ["stance-40", "stance-80"]
    assert all(row.covered for row in of_k)
    parts = list(dict.fromkeys((c.pathway, c.quantity) for c in contributions))
    assert parts == [(row.pathway, quantity) for row in of_k for quantity in ("I", "B", "K")]


def test_strides_are_divided_for_equal_uncertainty():
    assert allocation([300.0, 100.0, 100.0], 100, 5) == [60, 20, 20]
    found = allocation([179.7, 23.6, 13.1, 9.8], 150, 10)
    assert sum(found) == 150 and found[2:] == [10, 10] and found[0] == pytest.approx(7.6 * found[1], rel=0.05)
    with pytest.raises(InputError, match="10 perturbed strides for each of 4 phases, found 30"):
        allocation([1.0, 1.0, 1.0, 1.0], 30, 10)


# ---- what cannot be used ------------------------------------------------------------------------


def seen(walks, written, **changes):
    found = read_instruments(written / "walk.txt", DFLOW, 100.0, 0.1)
    scaled = {name: factor * getattr(found, name) for name, factor in changes.items()}
    strides = segment_strides(walks[1].heel_strikes, walks[1].toe_offs)
    return analyse_walking(replace(found, **scaled), strides, walks[1].onsets)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"angle": 180.0 / np.pi}, "an angle of the ankle in rad, found a range of"),
        ({"vertical": 1e-3, "other_vertical": 1e-3}, "150 to 5000 N in stance, found 0.7.*give forces in N"),
        ({"vertical": -1.0, "other_vertical": -1.0}, "found -7.*turn the sign"),
        ({"ankle_y": 1e3, "ankle_x": 1e3, "cop": 1e3}, "m above the belt in stance, found 110"),
        ({"ankle_x": 1e3}, "centre of pressure within 0.5 m of the ankle"),
    ],
    ids=lambda x: "-".join(x) if isinstance(x, dict) else "",
)
def test_another_unit_is_refused(changes, words, walks, written):
    with pytest.raises(InputError, match=words):
        seen(walks, written, **changes)


def test_events_in_milliseconds_are_refused(walks, written):
    found = read_instruments(written / "walk.txt", DFLOW, 100.0, 0.1)
    strides = segment_strides(1e3 * walks[1].heel_strikes, 1e3 * walks[1].toe_offs)
    with pytest.raises(InputError, match=r"events within the recording.*not in ms"):
        analyse_walking(found, strides, walks[1].onsets)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plates": WalkingPlates(3, 2)}, "a force plate 3, found 2 force plates"),
        ({"axes": WalkingAxes("+y", "+y")}, "two different axes"),
        ({"markers": {"ankle": "LMAL", "knee": "LKNE", "heel": "LHEE"}}, "found none for 'toe'"),
        ({"markers": {"ankle": "MAL", "knee": "LKNE", "heel": "LHEE", "toe": "LTOE"}}, "marker named 'MAL'"),
    ],
    ids=lambda x: "-".join(x) if isinstance(x, dict) else "",
)
def test_what_the_file_does_not_hold_is_named(changes, words, written):
    with pytest.raises(InputError, match=words):
        read_instruments(written / "walk.txt", replace(DFLOW, **changes), 100.0, 0.1)


def test_a_marker_that_is_hidden_for_long_is_refused_and_a_short_gap_is_filled(written):
    recording = read_recording(written / "walk.txt")
    whole = walking_recording(recording, DFLOW, 100.0, 0.1)

    def hidden(frames):
        positions = recording.markers.positions.copy()
        positions[1000 : 1000 + frames, 0] = np.nan
        markers = replace(recording.markers, positions=positions)
        return walking_recording(replace(recording, markers=markers), DFLOW, 100.0, 0.1)

    assert np.abs(hidden(5).ankle_x - whole.ankle_x).max() < 0.01
    with pytest.raises(InputError, match=r"marker 'LMAL' hidden for at most 0.1 s, found 0.3 s"):
        hidden(30)


WALL = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])  # of D-Flow, y is up


def plate_of(recording, **changes):
    """The recording with another first plate."""
    return replace(recording, plates=(replace(recording.plates[0], **changes), *recording.plates[1:]))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda r: plate_of(r, fault="walk: a plate of type 7"), "walk: a plate of type 7"),
        (
            lambda r: plate_of(r, force=np.nan * r.plates[0].force),
            "plate 1: expected a number in every",
        ),
        (lambda r: plate_of(r, force=0.0 * r.plates[0].force), "plate 1: expected a load, found zeros only"),
        (lambda r: plate_of(r, corners=WALL), "plate 1: expected a level surface"),
        (lambda r: replace(r, markers=None), "expected markers, found none"),
    ],
    ids=["fault", "gap", "zeros", "wall", "no-markers"],
)
def test_a_recording_that_cannot_be_used_is_refused(spoil, words, written):
    with pytest.raises(InputError, match=words):
        walking_recording(spoil(read_recording(written / "walk.txt")), DFLOW, 100.0, 0.1)
