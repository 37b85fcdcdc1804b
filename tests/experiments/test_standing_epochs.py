"""Responses of a standing person: cut where they begin, and nothing that cannot be trusted among them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import alike, assert_one_sentence
from emg_builders import EMG_RATE_HZ
from standing_builders import (
    CUTTING,
    LABELS,
    LIMIT_UV,
    MUSCLES,
    ONSETS_S,
    OPTIONS,
    RATE_HZ,
    USUAL,
    standing_trial,
    sway,
    true_torque,
    with_signal,
)

from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import cut_standing_epochs, epochs_of, epochs_result
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import TorquePathway
from tepsipe.io.result import read_result, write_result

PATHWAYS = {"ankle": TorquePathway("ankle", None)}
NAME = "standing/relax-pos-0.4"


@cache
def usual_trial():
    return standing_trial()


@cache
def usual_standing():
    return process_standing(usual_trial(), NAME, OPTIONS, PATHWAYS, {})


@cache
def usual():
    return cut_standing_epochs(usual_standing(), CUTTING)


def cut(trial, standing=None, options=CUTTING):
    standing = standing or process_standing(trial, NAME, OPTIONS, PATHWAYS, {})
    prepared = replace(standing.prepared, trial=trial)
    return cut_standing_epochs(replace(standing, prepared=prepared), options)


def hide(trial, label, start_s, stop_s):
    """The trial with a marker marked as hidden from start to stop (s)."""

    def mark(hidden):
        hidden[(trial.time >= start_s) & (trial.time < stop_s), LABELS.index(label)] = True

    return with_signal(trial, "marker_hidden", mark)


def same_but_for(found, kept, expected=None):
    """Whether all that was kept is what it was, bit for bit."""
    wanted = expected or usual()
    for group in ("perturbed", "stretch"):
        for key, x in getattr(wanted, group).items():
            assert (getattr(found, group)[key] == x[kept]).all(), key
    assert (found.emg == wanted.emg[kept]).all()
    assert (found.drive == wanted.drive[kept]).all()
    assert (found.onsets_s == wanted.onsets_s[kept]).all()


# ---- what is cut -------------------------------------------------------------------------------


@pytest.mark.slow
def test_responses_are_the_persons_from_the_instant_of_the_onset():
    found = usual()
    assert found.count == len(ONSETS_S)
    assert found.left_out == ()
    assert found.time[[0, 75, -1]] == pytest.approx([-0.3, 0.0, 1.0])
    zero = (found.time >= -0.1) & (found.time <= -0.02)
    # the same filter, on samples that lie at the onsets
    around = np.arange(-325, 501) / RATE_HZ
    for key, signal, apart in (
        ("ankle", lambda t: sway(USUAL, t)[0], 1.5e-4),
        ("torque/ankle", lambda t: true_torque(USUAL, t), 1.0),
    ):
        smooth = np.array([OPTIONS.lowpass(signal(onset + around), RATE_HZ) for onset in ONSETS_S])
        expected = smooth[:, 250:576] - smooth[:, 250:576][:, zero].mean(axis=1, keepdims=True)
        assert np.ptp(expected) > 30.0 * apart
        assert found.perturbed[key] == pytest.approx(expected, abs=apart)


def test_every_response_is_zero_in_its_baseline():
    zero = (usual().time >= -0.1) & (usual().time <= -0.02)
    for group in (usual().perturbed, usual().unperturbed):
        for key, x in group.items():
            level = x[:, zero].mean(axis=1)
            assert level == pytest.approx(np.zeros(len(x)), abs=1e-9 * np.ptp(x) + 1e-12), key
    drive = usual().drive[:, zero].mean(axis=1)
    assert drive == pytest.approx(np.zeros_like(drive), abs=1e-9)
    # velocities tell which muscle is stretched first, electromyograms where a burst begins: as they are
    assert np.ptp(usual().stretch["ankle"]) > 0.3
    assert np.ptp(usual().emg) > 100.0


def test_unperturbed_stretches_do_not_touch_perturbations():
    perturbed, unperturbed = (
        getattr(usual(), group)["belt_velocity"] for group in ("perturbed", "unperturbed")
    )
    assert np.abs(perturbed).max(axis=1).min() > 0.3
    # before the first and between all others, where 4.2 to 4.6 s less 2.1 s hold one of 1.3 s each
    assert len(unperturbed) >= 8
    # what the 20 Hz filter smears 25 ms ahead of the next onset, at the very end
    assert np.abs(unperturbed[:, usual().time < 0.97]).max() < 0.001
    assert np.abs(usual().unperturbed["ankle"]).max() < 0.1 * np.abs(usual().perturbed["ankle"]).max()


def test_bursts_are_where_they_were_made():
    found = usual()
    assert found.muscles == MUSCLES
    assert found.emg_time[[0, 300, -1]] == pytest.approx([-0.3, 0.0, 1.0])
    level = np.abs(found.emg).mean(axis=0)
    burst = (found.emg_time > 0.05) & (found.emg_time < 0.09)
    quiet = (found.emg_time < 0.03) | (found.emg_time > 0.2)
    assert (level[burst].mean(axis=0) > 5.0 * level[quiet].mean(axis=0)).all()
    # 60 uV of noise, of which 2 / pi in the mean, half of that over the burst
    assert (found.drive.mean(axis=0).max(axis=0) > 15.0).all()
    assert found.drive.shape == (6, found.time.size, 3)
    assert np.abs(found.unperturbed_drive.mean(axis=0)).max() < 5.0


@pytest.mark.slow
@pytest.mark.parametrize("shift_s", [7.3, -2.0])
def test_clock_that_starts_elsewhere_changes_nothing(shift_s):
    trial = usual_trial()
    axes = {key: trial.axes[key] + shift_s for key in ("time", "emg_time")}
    found = cut(replace(trial, axes=trial.axes | axes))
    assert found.onsets_s - shift_s == pytest.approx(usual().onsets_s, abs=1e-9)
    for group in ("perturbed", "unperturbed"):
        for key, x in getattr(usual(), group).items():
            assert alike(getattr(found, group)[key], x, abs=1e-6 * np.ptp(x) + 1e-12), key
    assert alike(found.drive, usual().drive, abs=1e-4)


@pytest.mark.parametrize("first_s", [3.9001, 3.9041, 3.91])
def test_record_that_begins_after_time_0_holds_every_unperturbed_stretch(first_s):
    # three stretches of 1.3 s fit, but only from the first sample on
    standing = usual_standing()
    onsets = np.array([first_s, *standing.onsets_s[1:]])
    moved = replace(standing, onsets_s=onsets, ends_s=np.array([first_s + 0.1, *standing.ends_s[1:]]))
    found = cut(usual_trial(), moved)
    assert found.count == 6
    assert len(found.unperturbed["ankle"]) >= 7


# ---- perturbations that are left out -------------------------------------------------------------


@pytest.mark.parametrize("label", ["ankle", "foot1", "thigh3"])
def test_marker_hidden_for_one_sample_while_the_belt_moves_leaves_that_response_out(label):
    found = cut(hide(usual_trial(), label, ONSETS_S[2] + 0.03, ONSETS_S[2] + 0.034))
    assert found.count == 5
    (said,) = found.left_out
    assert said.startswith(f"{NAME}: perturbation at 14.10 s left out: marker {label!r} was hidden")
    assert "while the belt moved" in said
    same_but_for(found, [0, 1, 3, 4, 5])


def test_marker_hidden_for_long_in_a_response_leaves_it_out_and_for_short_does_not():
    trial = hide(usual_trial(), "shank1", ONSETS_S[3] + 0.5, ONSETS_S[3] + 0.58)
    assert cut(trial).left_out == ()
    same_but_for(cut(trial), range(6))
    found = cut(hide(usual_trial(), "shank1", ONSETS_S[3] + 0.5, ONSETS_S[3] + 0.7))
    (said,) = found.left_out
    assert "perturbation at 18.34 s left out: marker 'shank1' was hidden for 0.2 s" in said
    assert "at most 0.1 s can be filled" in said
    same_but_for(found, [0, 1, 2, 4, 5])


def test_marker_hidden_before_an_onset_counts_as_well():
    found = cut(hide(usual_trial(), "thigh1", ONSETS_S[1] - 0.25, ONSETS_S[1] - 0.1))
    assert found.count == 5
    assert "9.40 s left out: marker 'thigh1'" in found.left_out[0]


def test_marker_that_nobody_uses_may_hide():
    trial = usual_trial()
    labels = np.array([*LABELS, "spare"])
    spare = {
        "marker_position": trial.values("marker_position")[:, :1] * 0.0,
        "marker_hidden": np.ones((trial.time.size, 1), dtype=bool),
    }
    signals = {
        key: replace(trial.signals[key], values=np.concatenate([trial.values(key), x], axis=1))
        for key, x in spare.items()
    }
    found = cut(replace(trial, axes=trial.axes | {"marker": labels}, signals=trial.signals | signals))
    assert found.left_out == ()


def test_unperturbed_stretch_with_a_hidden_marker_is_not_used():
    # 3.0 to 3.3 s lies in one of the stretches before the first perturbation at 5 s
    trial = hide(usual_trial(), "shank2", 3.0, 3.3)
    found = cut(trial)
    assert found.count == 6
    before, after = len(usual().unperturbed["ankle"]), len(found.unperturbed["ankle"])
    assert 0 < before - after <= 2
    assert len(found.unperturbed_drive) == len(found.unperturbed_usable) == after
    same_but_for(found, range(6))


def test_trial_without_any_unperturbed_stretch_in_view_is_refused():
    trial = usual_trial()
    for onset in ONSETS_S:
        trial = hide(trial, "shank2", onset + 1.05, onset + 5.0)
    with pytest.raises(InputError) as caught:
        cut(hide(trial, "shank2", 0.0, 4.6))
    assert_one_sentence(caught.value, NAME, "hidden")


@pytest.mark.parametrize(("which", "onset_s"), [(0, 0.2), (5, 32.3)])
def test_response_that_the_record_cuts_off_is_left_out(which, onset_s):
    standing = usual_standing()
    onsets, ends = standing.onsets_s.copy(), standing.ends_s.copy()
    onsets[which], ends[which] = onset_s, onset_s + 0.1
    found = cut(usual_trial(), replace(standing, onsets_s=onsets, ends_s=ends))
    (said,) = found.left_out
    assert f"perturbation at {onset_s:.2f} s left out: expected the record from 0.3 s before to 1 s" in said
    assert "cut off" in said
    same_but_for(found, [k for k in range(6) if k != which])


def test_response_into_which_the_next_perturbation_falls_is_left_out():
    standing = usual_standing()
    onsets, ends = standing.onsets_s.copy(), standing.ends_s.copy()
    onsets[3], ends[3] = onsets[2] + 1.2, ends[2] + 1.2
    found = cut(usual_trial(), replace(standing, onsets_s=onsets, ends_s=ends))
    (said,) = found.left_out
    assert "14.10 s left out: expected 1.3 s to the next perturbation, found 1.2 s" in said
    assert found.count == 5


def hidden_in(*perturbations):
    trial = usual_trial()
    for k in perturbations:
        trial = hide(trial, "ankle", ONSETS_S[k] + 0.02, ONSETS_S[k] + 0.03)
    return trial


def test_trial_with_too_few_responses_is_left_out_as_a_whole():
    assert cut(hidden_in(0, 4)).count == 4
    found = cut(hidden_in(0, 2, 4))
    assert found.count == 0
    assert len(found.left_out) == 4
    assert "left out as a whole: expected at least 4 usable perturbations, found 3" in found.left_out[-1]
    assert found.perturbed["ankle"].shape == (0, found.time.size)
    assert found.drive.shape == (0, found.time.size, 3)
    assert found.usable.shape == (0, 3)


def test_trial_of_who_steps_is_left_out_as_a_whole_with_the_reason():
    step = "the foot's marker 'foot1' was lifted by 5 cm at 12.0 s: a step, repeat the trial"
    found = cut(usual_trial(), replace(usual_standing(), fault=step))
    assert found.count == 0
    assert found.muscles == ()
    assert found.left_out == (f"{NAME}: left out as a whole: {step}",)


# ---- muscles that are left out -------------------------------------------------------------------


def with_channel(change, column=1):
    """The usual trial with one channel of electromyograms that ``change`` has altered in place."""
    return with_signal(usual_trial(), "emg", lambda x: change(x[:, column], usual_trial().axes["emg_time"]))


def flat(x, time):
    x[:] = 0.0


def saturated(x, time):
    x[time % 1.0 < 0.05] = LIMIT_UV


def humming(x, time):
    x[:] = 200.0 * np.sin(2.0 * np.pi * 50.0 * time)


def unplugged(x, time):
    x[1000:1010] = np.nan


FAULTS = {
    "flat": (flat, "the channel is flat"),
    "saturated": (saturated, "at the recorder's limits"),
    "disconnected": (humming, "an electrode was disconnected"),
    "not a number": (unplugged, "a number in every sample"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_muscle_with_a_faulty_channel_is_named_and_left_out(fault):
    change, said = FAULTS[fault]
    found = cut(with_channel(change), usual_standing())
    assert found.muscles == ("TA", "GAS")
    (sentence,) = found.left_out
    assert sentence.startswith(f"{NAME}: muscle SOL left out: expected")
    assert said in sentence
    others = replace(usual(), emg=usual().emg[..., [0, 2]], drive=usual().drive[..., [0, 2]])
    same_but_for(found, range(6), others)


def test_muscle_without_a_channel_is_named():
    trial = usual_trial()
    attributes = trial.attributes | {"emg_missing": "BF, RF"}
    found = cut(replace(trial, attributes=attributes), usual_standing())
    assert [said.split(":")[1] for said in found.left_out] == [" muscle BF left out", " muscle RF left out"]
    assert found.muscles == MUSCLES
    same_but_for(found, range(6))


def clipped_at(*instants):
    def change(x, time):
        for instant in instants:
            x[np.abs(time - instant) < 0.004] = -LIMIT_UV

    return with_channel(change)


def test_muscle_clipped_in_one_perturbation_is_left_out_there_alone():
    found = cut(clipped_at(ONSETS_S[1] + 0.3), usual_standing())
    (said,) = found.left_out
    assert said.startswith(f"{NAME}: perturbation at 9.40 s left out for muscle SOL: the amplifier was clip")
    expected = np.ones((6, 3), dtype=bool)
    expected[1, 1] = False
    assert (found.usable == expected).all()
    assert found.unperturbed_usable.all()
    assert found.count == 6
    others = [0, 2]
    assert (found.drive[..., others] == usual().drive[..., others]).all()
    assert (found.perturbed["torque/ankle"] == usual().perturbed["torque/ankle"]).all()
    # a filter forgets in a tenth of a second: the other responses of this muscle are what they were
    kept = found.usable[:, 1]
    assert found.drive[kept, :, 1] == pytest.approx(usual().drive[kept, :, 1], abs=0.1)


def test_muscle_clipped_in_unperturbed_standing_is_not_compared_with_that():
    found = cut(clipped_at(3.1), usual_standing())
    assert found.left_out == ()
    assert found.usable.all()
    assert (~found.unperturbed_usable).sum(axis=0).tolist() == [0, 1, 0]
    wrong = np.abs(found.unperturbed_drive[..., 1]).max(axis=1)
    assert wrong.argmax() == np.flatnonzero(~found.unperturbed_usable[:, 1])[0]
    assert wrong.max() > 100.0


def test_muscle_clipped_in_every_perturbation_is_left_out():
    found = cut(clipped_at(*[onset + 0.06 for onset in ONSETS_S]), usual_standing())
    assert found.muscles == ("TA", "GAS")
    assert "muscle SOL left out: clipped in every perturbation" in found.left_out[-1]
    assert len(found.left_out) == 7


def test_electromyograms_at_a_rate_that_does_not_fit_are_refused():
    trial = usual_trial()
    time = trial.axes["emg_time"]
    slow = time[0] + np.arange(time.size) / 990.0
    odd = replace(
        trial, axes=trial.axes | {"emg_time": slow}, attributes=trial.attributes | {"emg_rate_hz": 990.0}
    )
    with pytest.raises(InputError) as caught:
        cut(odd, usual_standing())
    assert_one_sentence(caught.value, "250 Hz", "990 Hz")
    assert EMG_RATE_HZ % RATE_HZ == 0.0


# ---- to a file and back --------------------------------------------------------------------------


@pytest.mark.slow
def test_responses_come_back_from_their_file(tmp_path):
    made = cut(clipped_at(ONSETS_S[1] + 0.3), usual_standing())
    write_result(tmp_path / "responses.h5", epochs_result(made))
    read = epochs_of(read_result(tmp_path / "responses.h5"))
    assert read.muscles == made.muscles
    assert read.left_out == made.left_out
    assert read.count == made.count
    for key in ("time", "emg_time", "onsets_s", "usable", "unperturbed_usable"):
        assert (getattr(read, key) == getattr(made, key)).all(), key
        assert getattr(read, key).dtype == getattr(made, key).dtype
    for key in ("drive", "unperturbed_drive", "envelope", "emg"):
        assert alike(getattr(read, key), getattr(made, key), rel=1e-6, abs=1e-4), key
    for group in ("perturbed", "unperturbed", "stretch"):
        assert getattr(read, group).keys() == getattr(made, group).keys()
        for key, x in getattr(made, group).items():
            assert alike(getattr(read, group)[key], x, rel=1e-6, abs=1e-6 * np.ptp(x) + 1e-12), key


def test_units_of_the_file_are_those_of_the_responses():
    units = epochs_result(usual()).units
    assert units["perturbed/torque/ankle"] == units["unperturbed/torque/ankle"] == "Nm"
    assert units["perturbed/ankle_dd"] == "rad/s2"
    assert units["perturbed/f_y"] == "N"
    assert units["stretch/knee"] == "rad/s"
    assert units["emg"] == units["drive"] == "uV"
    assert set(units) == set(epochs_result(usual()).arrays)


def test_trial_without_responses_comes_back_too(tmp_path):
    made = cut(hidden_in(0, 2, 4))
    write_result(tmp_path / "none.h5", epochs_result(made))
    read = epochs_of(read_result(tmp_path / "none.h5"))
    assert read.count == 0
    assert read.left_out == made.left_out
    assert read.perturbed["ankle"].shape == (0, made.time.size)
    assert read.usable.dtype == bool
