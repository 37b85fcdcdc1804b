"""Trials whose signals cannot be those of the rig are refused, and those that can be are kept as they are."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from builders import DUMMY_DURATION_S, RATE_HZ, assert_one_sentence, multisine_record, trial_of

from tepsipe.errors import InputError
from tepsipe.ingest.agreement import belt_fixed_motion
from tepsipe.ingest.limits import Limits, Rig, frozen_stretch, held_while_moving
from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.io.trial import recorded_faults
from workflow.settings.complete import settings_of, without
from workflow.support.rigs import RIG_KEYS, rig_of

LABELS = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]
FILES = {"log": "log.mat", "calibration": "matrix.csv", "markers": "markers.c3d"}
MANIPULATOR = {"log": "log.txt", "command": "command.txt"}
ON_LOG, ON_MARKERS, ON_COMMAND = "log.mat", "markers.c3d", "command.txt"


@pytest.fixture(scope="module")
def limits(shipped_config):
    return Limits(**without(shipped_config["plausible"], *RIG_KEYS))


@pytest.fixture(scope="module")
def rig(shipped_config):
    return Rig(**rig_of(settings_of(shipped_config), "dummy"))


@pytest.fixture(scope="module")
def dummy(dummy_files):
    options = TreadmillOptions(250.0, 0.1, 2500.0, 2.5)
    return ingest_treadmill_files(dummy_files, LABELS, options, DUMMY_DURATION_S)


@pytest.fixture(scope="module")
def joint():
    torque, angle = multisine_record((0.01, 0.2, 10.0), 2)
    return trial_of(256.0, torque=(torque, "Nm"), angle=(angle, "rad"))


def with_values(trial, name, values):
    signal = replace(trial.signals[name], values=values)
    return replace(trial, signals=trial.signals | {name: signal})


def changed(trial, name, change):
    """The trial with one of its signals changed in place by a function of a copy."""
    values = copy.deepcopy(trial.values(name))
    answer = change(values)
    return with_values(trial, name, values if answer is None else answer)


def freeze_markers(trial, labels, start, stop):
    """Markers that keep the position of the sample before a stretch, in both kinds of instants."""
    for name in ("marker_position", "marker_position_as_sampled"):

        def hold(x):
            for label in labels:
                x[start:stop, LABELS.index(label)] = x[max(0, start - 1), LABELS.index(label)]

        trial = changed(trial, name, hold)
    return trial


def both_markers(trial, change):
    for name in ("marker_position", "marker_position_as_sampled"):
        trial = changed(trial, name, change)
    return trial


def one_sample(index, value):
    def put(x):
        x[index] = value

    return put


@pytest.mark.slow
def test_trial_of_the_laboratory_is_kept_as_it_is(dummy, limits, rig):
    assert plausible_trial(dummy, limits, rig, FILES) is dummy


@pytest.mark.parametrize(
    ("changes", "flagged"),
    [
        ({}, False),
        ({"amplitude_m_per_s": 0.13}, True),
        ({"amplitude_m_per_s": 0.31}, True),
        ({"amplitude_m_per_s": None}, False),
    ],
)
def test_other_amplitude_than_the_sheets_is_a_fault(changes, flagged, dummy, limits, rig):
    command = dummy.values("belt_command")
    stated = replace(rig, amplitude_m_per_s=float(np.abs(command).max()))
    slow = changed(dummy, "belt_command", lambda x: 0.2 / np.abs(command).max() * x)
    for trial, of_rig in ((dummy, stated), (slow, replace(rig, **{"amplitude_m_per_s": 0.2} | changes))):
        found = plausible_trial(trial, limits, of_rig, FILES)
        assert recorded_faults(found) == (("other-amplitude",) if flagged and trial is slow else ())


def test_belt_without_a_command_may_fall_short_of_its_amplitude(dummy, limits, rig):
    signals = {name: x for name, x in dummy.signals.items() if name != "belt_command"}
    belt = replace(dummy, signals=signals)
    highest = float(np.abs(belt.values("belt_velocity")).max())
    for factor, fault in ((1.0, ()), (0.84, ()), (0.5, ("other-amplitude",)), (1.5, ("other-amplitude",))):
        of_rig = replace(rig, amplitude_m_per_s=highest / factor)
        assert recorded_faults(plausible_trial(belt, limits, of_rig, FILES)) == fault


def test_reversed_belt_velocity_of_a_person_is_refused_by_its_name(dummy, limits):
    reversed_belt = changed(dummy, "belt_velocity", lambda x: -x)
    with pytest.raises(InputError) as caught:
        plausible_trial(
            reversed_belt, limits, Rig("right", belt_fixed=("foot1", "foot2"), person=True), FILES
        )
    assert_one_sentence(caught.value, ON_LOG, "'foot1'", "reverse the sign of the belt velocity")


LEG = ("leg1", "leg2", "leg3", "leg4")
# name -> how the trial is spoiled, file that the sentence names, words of the sentence
SPOILED = {
    "leg frozen at its first frame": (lambda t: freeze_markers(t, LEG, 0, None), ON_MARKERS, "'leg1'"),
    "leg frozen for the last fifth": (
        lambda t: freeze_markers(t, LEG, -600, None),
        ON_MARKERS,
        "same position",
    ),
    "one marker frozen for 0.2 s": (lambda t: freeze_markers(t, ("leg3",), 900, 950), ON_MARKERS, "'leg3'"),
    "one foot marker frozen": (lambda t: freeze_markers(t, ("foot2",), 0, None), ON_MARKERS, "'foot2'"),
    "leg that shows only noise": (
        lambda t: both_markers(
            t,
            lambda x: np.concatenate(
                [x[:, :4], x[:1, 4:] + 1e-4 * np.random.default_rng(1).standard_normal(x[:, 4:].shape)],
                axis=1,
            ),
        ),
        ON_MARKERS,
        "markers of the leg to move",
    ),
    "markers in mm": (lambda t: both_markers(t, lambda x: 1000.0 * x), ON_MARKERS, "unit of length"),
    "markers in cm": (lambda t: both_markers(t, lambda x: 100.0 * x), ON_MARKERS, "unit of length"),
    "markers a tenth too large": (
        lambda t: both_markers(t, lambda x: 1.15 * x),
        ON_MARKERS,
        "times its velocity",
    ),
    "one jump of a marker": (
        lambda t: both_markers(t, one_sample((1000, 5, 1), 3.0)),
        ON_MARKERS,
        "'leg2' at",
    ),
    "markers mirrored": (
        lambda t: both_markers(t, lambda x: x * [1, -1, 1]),
        ON_MARKERS,
        "reverse the sign of the belt velocity",
    ),
    "markers half a second late": (
        lambda t: both_markers(t, lambda x: np.roll(x, 125, axis=0)),
        ON_MARKERS,
        "belt",
    ),
    "markers 52 ms late": (
        lambda t: both_markers(t, lambda x: np.roll(x, 13, axis=0)),
        ON_MARKERS,
        "52 ms later, the longest delay",
    ),
    "belt velocity in mm/s": (lambda t: changed(t, "belt_velocity", lambda x: 1000.0 * x), ON_LOG, "m/s"),
    "belt velocity in cm/s": (lambda t: changed(t, "belt_velocity", lambda x: 100.0 * x), ON_LOG, "m/s"),
    "belt velocity in km/h": (lambda t: changed(t, "belt_velocity", lambda x: 3.6 * x), ON_MARKERS, "0.27"),
    "one sample of the belt velocity": (
        lambda t: changed(t, "belt_velocity", one_sample(700, 3.0)),
        ON_LOG,
        "acceler",
    ),
    "one sample of the command": (
        lambda t: changed(t, "belt_command", one_sample(700, 1e6)),
        ON_LOG,
        "1e+06",
    ),
    "belt velocity stuck": (
        lambda t: changed(t, "belt_velocity", lambda x: 0.0 * x),
        ON_MARKERS,
        "correlation",
    ),
    "one sample of 1e6": (lambda t: changed(t, "force", one_sample((800, 1, 1), 1e6)), ON_LOG, "right, y at"),
    "not a number": (lambda t: changed(t, "moment", one_sample((800, 1, 0), np.nan)), ON_LOG, "nan"),
    "forces times 1000": (lambda t: changed(t, "force", lambda x: 1000.0 * x), ON_LOG, "calibration"),
    "forces over 1000": (lambda t: changed(t, "force", lambda x: 0.001 * x), ON_LOG, "1.5 to 3.5 kg"),
    "no force": (lambda t: changed(t, "force", lambda x: 0.0 * x), ON_LOG, "0 N throughout"),
    "no moment": (lambda t: changed(t, "moment", lambda x: 0.0 * x), ON_LOG, "Mx of the right belt"),
    "plate frozen for half a second": (
        lambda t: changed(t, "force", one_sample((slice(500, 625), 1, 1), 3.0)),
        ON_LOG,
        "Fy",
    ),
    "gain that changes": (
        lambda t: changed(t, "force", lambda x: np.concatenate([x[:1500], 1.6 * x[1500:]])),
        ON_LOG,
        "the same mass on the right belt throughout",
    ),
    "plate upside down": (lambda t: changed(t, "force", lambda x: -x), ON_LOG, "kg on the right belt"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_what_the_treadmill_cannot_have_recorded_is_refused(name, dummy, limits, rig):
    spoil, file, words = SPOILED[name]
    with pytest.raises(InputError) as caught:
        plausible_trial(spoil(dummy), limits, rig, FILES)
    assert_one_sentence(caught.value, file, words)


def test_belt_that_is_not_perturbed_is_left_to_the_analysis(dummy, limits, rig, rng):
    def still(x):
        return x[:1] + 1e-4 * rng.standard_normal(x.shape).astype(np.float32)

    noise = 0.001 * rng.standard_normal(dummy.time.size)
    quiet = changed(both_markers(dummy, still), "belt_velocity", lambda x: noise)
    assert plausible_trial(quiet, limits, rig, FILES) is quiet


@pytest.mark.slow
def test_markers_of_another_trial_are_refused(dummy, short_truth, limits, rig, tmp_path):
    from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
    from tepsipe.virtual_lab.treadmill_trial import Protocol

    files = {kind: tmp_path / name for kind, name in FILES.items()}
    for condition, amplitude, interval_s, words in (
        ("sine-0.3", 0.3, 2.0, "times its velocity"),
        ("sine-0.5", 0.5, 2.5, "correlation"),
    ):
        protocol = Protocol("sine", amplitude, interval_s, DUMMY_DURATION_S)
        make_dummy_trial(short_truth, condition, protocol, files)
        options = TreadmillOptions(250.0, 0.1, 2500.0, 2.5)
        other = ingest_treadmill_files(files, LABELS, options, DUMMY_DURATION_S)
        mixed = dummy
        for name in ("marker_position", "marker_position_as_sampled", "marker_hidden"):
            mixed = with_values(mixed, name, other.values(name))
        with pytest.raises(InputError) as caught:
            plausible_trial(mixed, limits, rig, FILES)
        assert_one_sentence(caught.value, ON_MARKERS, words)


def test_a_persons_frozen_marker_is_hidden_for_as_long_and_refused_if_it_never_moves(dummy, limits):
    person = Rig(belt="right", belt_fixed=("foot1", "ankle"), person=True)
    frozen = freeze_markers(dummy, ("leg2",), 900, 1000)
    hidden = plausible_trial(frozen, limits, person, FILES).values("marker_hidden")
    expected = dummy.values("marker_hidden").copy()
    expected[899:1000, LABELS.index("leg2")] = True
    assert (hidden == expected).all()
    with pytest.raises(InputError, match="leg2"):
        plausible_trial(freeze_markers(dummy, ("leg2",), 0, 2000), limits, person, FILES)


def test_a_step_of_a_person_is_left_to_the_analysis(dummy, limits):
    person = Rig(belt="right", belt_fixed=("foot1",), person=True)
    stepped = both_markers(
        dummy, lambda x: x + np.clip(np.arange(len(x)) - 1500, 0, 60)[:, None, None] * np.float32(0.001)
    )
    assert plausible_trial(stepped, limits, person, FILES) is stepped


# ---- a joint in a manipulator -----------------------------------------------------------------------


def test_joint_that_follows_its_torque_is_kept(joint, limits):
    assert plausible_trial(joint, limits, Rig(), MANIPULATOR) is joint


@pytest.mark.parametrize(
    ("name", "change", "file", "words"),
    [
        ("angle", lambda x: -x, "log.txt", "sign"),
        ("torque", lambda x: -x, "log.txt", "sign"),
        ("angle", lambda x: 0.001 * x, ON_COMMAND, "N·m per rad"),
        ("torque", lambda x: 1000.0 * x, ON_COMMAND, "plausible.torque_Nm"),
        ("angle", one_sample(700, 4.0), "log.txt", "joint angle"),
        ("angle", lambda x: x + 0.4 * (np.arange(x.size) // 2 % 2), "log.txt", "a joint of at most"),
        ("angle", one_sample(slice(700, 900), 0.01), "log.txt", "constant from"),
        ("torque", one_sample(700, np.nan), ON_COMMAND, "nan"),
    ],
)
def test_what_a_manipulator_cannot_have_recorded_is_refused(name, change, file, words, joint, limits):
    with pytest.raises(InputError) as caught:
        plausible_trial(changed(joint, name, change), limits, Rig(), MANIPULATOR)
    assert_one_sentence(caught.value, file, words)


def test_command_that_pauses_is_no_frozen_channel(joint, limits):
    paused = changed(joint, "torque", one_sample(slice(700, 900), 0.0))
    assert plausible_trial(paused, limits, Rig(), MANIPULATOR) is paused
    with pytest.raises(InputError, match="torque to change"):  # which was measured, not commanded
        plausible_trial(paused, limits, Rig(), {"log": "table.csv"})


def test_rate_that_no_instrument_has_is_refused(joint, limits):
    with pytest.raises(InputError, match="sampling rate"):
        plausible_trial(replace(joint, rate_hz=2.56), limits, Rig(), MANIPULATOR)


# ---- frozen channels, belt-fixed markers ---------------------------------------------------------------


def test_frozen_stretch_is_found_where_it_is(rng):
    x = rng.standard_normal((1000, 3))
    x[300:340] = x[300]
    assert frozen_stretch(x, RATE_HZ, 0.1) == (300, 340)
    assert frozen_stretch(x, RATE_HZ, 0.2) is None
    ignored = np.zeros(1000, dtype=bool)
    ignored[310:330] = True
    assert frozen_stretch(x, RATE_HZ, 0.1, ignored) is None
    assert frozen_stretch(np.ones((1000, 1)), RATE_HZ, 0.1) == (0, 1000)


@pytest.mark.parametrize("step", [1.0, 2.0])
def test_quantised_channel_that_rests_is_not_frozen(step, rng):
    slow = np.cumsum(0.05 * rng.standard_normal((4000, 3)), axis=0)
    quantised = step * np.round(slow / step)
    assert (np.diff(quantised, axis=0) == 0).all(axis=1).mean() > 0.5
    assert frozen_stretch(quantised, RATE_HZ, 0.1) is None


def test_held_signal_is_found_only_while_the_other_moves(rng):
    other, x = np.sin(np.arange(2000) / 50.0), rng.standard_normal(2000)
    x[500:700] = 0.3
    assert held_while_moving(x, other, RATE_HZ, 0.3) == (500, 700)
    other[400:800] = 0.0
    assert held_while_moving(x, other, RATE_HZ, 0.3) is None


def test_scale_and_delay_of_a_belt_fixed_marker_are_found(rng):
    belt = np.convolve(rng.standard_normal(3000), np.hanning(25), mode="same")
    marker = 0.8 * np.roll(belt, 5) + 0.01 * rng.standard_normal(3000)
    scale, delay_s, correlation = belt_fixed_motion(marker, belt, RATE_HZ, 0.05)
    assert scale == pytest.approx(0.8, rel=0.01)
    assert delay_s == pytest.approx(0.02)
    assert correlation > 0.99
    assert belt_fixed_motion(rng.standard_normal(3000), belt, RATE_HZ, 0.05)[2] < 0.3


REAL = ("Gait.c3d", "HC002D02.c3d", "HC002D06.c3d", "Qualisys.c3d")


@pytest.mark.parametrize("name", REAL)
def test_no_marker_of_real_recordings_counts_as_frozen(name, real_data):
    import ezc3d

    file = ezc3d.c3d(str(real_data(f"c3d/{name}")))
    points = file["data"]["points"][:3].transpose(2, 1, 0) / 1000.0
    rate, labels = (
        file["parameters"]["POINT"]["RATE"]["value"][0],
        file["parameters"]["POINT"]["LABELS"]["value"],
    )
    kinds = file["parameters"]["POINT"]
    derived = {
        label
        for key in ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
        for label in kinds.get(key, {"value": []})["value"]
    }
    checked = 0
    for k, label in enumerate(labels):
        position = points[:, k]
        if label in derived or not np.isfinite(position).any():
            continue
        hidden = ~np.isfinite(position).all(axis=1)
        assert frozen_stretch(position, rate, 0.1, hidden) is None, label
        checked += 1
    assert checked > 10
