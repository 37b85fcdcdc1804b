"""Centre of the ankle from quiet sway, and the feet as a free body up to 60 Hz: an ideal laboratory."""

from dataclasses import dataclass, replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from standing_builders import (
    CUTTING,
    DAMPING,
    LABELS,
    LAYOUT,
    OPTIONS,
    PERSON,
    STIFFNESS,
    USUAL,
    Stance,
    standing_trial,
)

from tepsipe.experiments.standing.epochs import cut_standing_epochs
from tepsipe.experiments.standing.free_reflex.broadband import broadband_of, broadband_result, cut_broadband
from tepsipe.experiments.standing.free_reflex.fit import fit_free_reflex
from tepsipe.experiments.standing.free_reflex.free_body import (
    FOREFOOT_SHARE,
    SOURCES,
    centre_from_sway,
    hindfoot,
    parts_of_foot,
    relative_motion,
    rotation_per_place,
    tissue_from_pulses,
    tissue_motion,
)
from tepsipe.experiments.standing.free_reflex.results import at_rotation, foot_rotation
from tepsipe.experiments.standing.joint_torque import process_standing
from tepsipe.experiments.standing.options import FreeReflexOptions, TorquePathway
from tepsipe.io.result import joined, read_result, write_result
from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.statistics.uncertainty import Source

RATE_HZ = 250.0
WIDE = Lowpass(60.0, 4, True)
FREE = FreeReflexOptions(60.0, 0.02, 0.008, 1.6, 0.02, 0.5, 0.045, 0.004, (0.04, 0.08))


def swaying(centre=(0.006, -0.004), slip_m_per_rad=0.0, foot_share=0.0, seconds=20.0, noise_m=6e-6, seed=1):
    """Markers of a shank that sways about a centre that lies beside the assumed one, on a foot."""
    time = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    rng = np.random.default_rng(seed)
    angle = 0.05 + 0.004 * np.sin(2.0 * np.pi * 0.31 * time) + 0.003 * np.sin(2.0 * np.pi * 0.83 * time)
    foot = foot_share * (angle - 0.05)
    a, up = np.array(centre), np.array([0.3, 0.08])
    positions = np.zeros((time.size, len(LABELS), 3))
    for segment in ("foot", "shank"):
        turn = foot if segment == "foot" else angle
        # the shank turns about its centre, which the foot carries; the foot about the centre, too
        about = a if segment == "shank" else np.zeros(2)
        for label, (across, along) in LAYOUT[segment].items():
            dy, dz = across - about[0], along - about[1]
            k = LABELS.index(label)
            positions[:, k, 1] = up[0] + dy * np.cos(turn) + dz * np.sin(turn)
            positions[:, k, 2] = up[1] - dy * np.sin(turn) + dz * np.cos(turn)
    positions[:, LABELS.index("ankle"), 1] += slip_m_per_rad * (angle - 0.05)
    positions[..., 1:] += noise_m * rng.standard_normal(positions[..., 1:].shape)
    return Trial(
        rate_hz=RATE_HZ,
        axes={"time": time, "marker": np.array(LABELS)},
        signals={"marker_position": Signal(positions, "m", ("time", "marker", "axis"))},
    )


def found(trial, gaps=4):
    quiet = np.ones(trial.time.size, dtype=bool)
    quiet[:: trial.time.size // gaps] = False
    return centre_from_sway(trial, PERSON, quiet, np.zeros((trial.time.size, len(LABELS)), dtype=bool))


@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.006, -0.004), (-0.01, 0.01)])
def test_centre_is_where_the_shank_turns(centre):
    # the markers are placed about the true centre: it lies there in the shank
    seen = found(swaying(centre))
    assert seen.offset_m == pytest.approx(centre, abs=2e-4)
    assert (seen.standard_error_m < 2e-4).all() and seen.foot_rad < 0.01 * seen.sway_rad


def test_noise_of_the_cameras_does_not_move_the_centre():
    centre = (0.006, -0.004)
    seen = [found(swaying(centre, noise_m=5e-4, seed=seed, seconds=40.0)) for seed in range(24)]
    offsets = np.array([one.offset_m for one in seen])
    error = offsets.std(axis=0, ddof=1) / np.sqrt(len(seen))
    assert (np.abs(offsets.mean(axis=0) - centre) < 3.5 * error).all()
    # attenuation would move it by millimetres
    assert error.max() < 1e-3
    stated = np.sqrt(np.mean([one.standard_error_m**2 for one in seen], axis=0))
    assert stated == pytest.approx(offsets.std(axis=0, ddof=1), rel=0.6)


def test_slip_of_the_malleolus_marker_moves_the_centre_by_little():
    seen = found(swaying(slip_m_per_rad=0.004))
    assert seen.offset_m == pytest.approx((0.006, -0.004), abs=3e-4)
    assert np.abs(seen.moving_m - (0.006, -0.004)).max() > 1e-3


def test_too_few_stretches_show_no_centre():
    assert found(swaying(seconds=2.0), gaps=2) is None


def test_foot_that_turns_is_seen():
    assert found(swaying(foot_share=0.5)).foot_rad > 0.8 * found(swaying(foot_share=0.5)).sway_rad


def test_hindfoot_turns_more_than_its_markers_where_the_forefoot_turns_half_as_much():
    tilt = np.linspace(0.0, 0.002, 5)
    positions = np.zeros((tilt.size, len(LABELS), 2))
    for label, (across, along) in LAYOUT["foot"].items():
        turned = (FOREFOOT_SHARE if across > 0.0 else 1.0) * tilt
        positions[:, LABELS.index(label)] = np.column_stack(
            [across + along * turned + 0.3, along - across * turned + 0.08]
        )
    angle, carried = hindfoot(positions, list(LABELS), PERSON)
    assert angle == pytest.approx(tilt, abs=1e-9)
    assert carried == pytest.approx(np.tile([0.3, 0.08], (tilt.size, 1)), abs=1e-9)


def tilted(share, tilt, noise_m=0.0, rng=None):
    """Markers of a foot whose hindfoot tilts by an angle (rad), and whose forefoot follows by a share."""
    positions = np.zeros((*tilt.shape, len(LABELS), 2))
    for label, (across, along) in LAYOUT["foot"].items():
        turned = (share if across > 0.0 else 1.0) * tilt
        positions[..., LABELS.index(label), :] = np.stack(
            [across + along * turned + 0.3, along - across * turned + 0.08], axis=-1
        )
    return positions if rng is None else positions + noise_m * rng.standard_normal(positions.shape)


def pulses_of(share, noise_m, seed=1, pulses=24, places=None):
    """A trial whose pulses tilt the foot by 1.5 mrad, each with sway of its own; as far as its foot goes."""
    rng, time = np.random.default_rng(seed), np.arange(-30, 51) / RATE_HZ
    sway = 3e-4 * rng.standard_normal((pulses, 1)) * np.linspace(0.0, 1.0, time.size)
    tilt = 1.5e-3 * np.clip(time / 0.1, 0.0, 1.0) + sway
    positions = tilted(share, tilt.ravel(), noise_m, rng)
    assumed = hindfoot(positions, list(LABELS), PERSON)[0]
    rotations = np.column_stack([assumed, 0.0 * assumed, parts_of_foot(positions, list(LABELS), PERSON)])
    rotations = rotations.reshape(pulses, time.size, 4)
    return SimpleNamespace(
        time=time,
        count=pulses,
        belt=np.column_stack([np.where(time > 0.0, 0.5, 0.0), 0.0 * time]),
        tilt=rotations - rotations[:, time <= 0.0].mean(axis=1, keepdims=True),
        rotation_per_m=rotation_per_place(PERSON),
    )


def rotation_for(share):
    """Rotation of the hindfoot over the one for the assumed share, of a foot with another share."""
    positions = tilted(share, np.array([0.0, 1e-3]))
    return 1e-3 / np.diff(hindfoot(positions, list(LABELS), PERSON)[0])[0]


ASSUMED = {"foot_rotation": Source("foot_rotation", 0.2)}


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0])
def test_pulses_show_the_share_of_the_forefoot(share):
    seen = foot_rotation([pulses_of(share, 6.5e-6)], ASSUMED)
    assert seen.share == pytest.approx(share, abs=0.02) and seen.share_error < 0.02
    assert seen.rotation == pytest.approx(rotation_for(share), abs=0.01)


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_noise_of_the_cameras_does_not_bias_the_share(share):
    """Thirty times the noise of the shipped cameras, and no assumption that would hide a bias."""
    unknown = {"foot_rotation": Source("foot_rotation", 1e3)}
    found = [foot_rotation([pulses_of(share, 2e-4, seed)], unknown) for seed in range(40)]
    rotation = np.array([one.rotation for one in found])
    error = rotation.std(ddof=1)
    assert rotation.mean() == pytest.approx(rotation_for(share), abs=3.5 * error / np.sqrt(40))
    assert np.sqrt(np.mean([one.error**2 for one in found])) == pytest.approx(error, rel=0.4)
    # the noise is large enough to attenuate products of the same pulses
    trial = pulses_of(share, 2e-4)
    own = (trial.tilt[..., 2] * trial.tilt[..., 0]).sum() / (trial.tilt[..., 0] ** 2).sum()
    assert abs(own - rotation_for(share)) > 3.5 * error / np.sqrt(40)


def test_assumed_share_remains_where_pulses_do_not_show_it():
    still = [pulses_of(1.0, 6.5e-6)]
    still[0].tilt = 6e-5 * np.random.default_rng(1).standard_normal(still[0].tilt.shape)
    seen = foot_rotation(still, ASSUMED)
    assert seen.rotation == pytest.approx(1.0, abs=0.1) and 0.15 < seen.error <= 0.2
    assert seen.share is None
    still[0].tilt = 0.0 * still[0].tilt
    assert foot_rotation(still, ASSUMED).rotation == 1.0
    known = foot_rotation([pulses_of(1.0, 6.5e-6)], ASSUMED)
    assert known.error < 0.02
    placed = foot_rotation(
        [pulses_of(1.0, 6.5e-6)], ASSUMED | {"foot_markers_m": Source("foot_markers_m", 0.001)}
    )
    # 1 mm of each height: 1.5 % for each marker
    assert placed.error == pytest.approx(0.022 * known.rotation, rel=0.1)


def test_markers_in_line_with_the_ankle_do_not_show_the_parts_of_the_foot():
    in_line = replace(PERSON.foot, layout_m=np.array([[0.14, -0.07], [-0.05, 0.025], [0.0, 0.0]]))
    assert rotation_per_place(replace(PERSON, foot=in_line)) is None
    trial = pulses_of(1.0, 6.5e-6)
    trial.rotation_per_m = None
    assert foot_rotation([trial], ASSUMED).rotation == 1.0


def test_centre_follows_the_rotation_of_the_foot():
    """A rigid foot that tilts with the shank: assuming a soft one moves the centre by centimetres."""
    trial, quiet = swaying(foot_share=-0.15), np.ones(5000, dtype=bool)
    quiet[:: quiet.size // 4] = False
    hidden = np.zeros((quiet.size, len(LABELS)), dtype=bool)
    centres = [centre_from_sway(trial, PERSON, quiet, hidden, rotation) for rotation in (1.0, 0.6, 1.4)]
    epochs = SimpleNamespace(centre=centres[0], skin_m=0.0, turned=tuple((c, 0.0) for c in centres[1:]))
    assert np.abs(centres[0].offset_m - (0.006, -0.004)).max() > 0.003
    rigid = at_rotation(epochs, rotation_for(1.0))[0]
    assert rigid.offset_m == pytest.approx((0.006, -0.004), abs=3e-4)
    between = centre_from_sway(trial, PERSON, quiet, hidden, 0.8)
    assert at_rotation(epochs, 0.8)[0].offset_m == pytest.approx(between.offset_m, abs=1e-4)


def pulsed(seconds=2.0):
    """Markers that ride on the belt through a pulse (m), and its acceleration (m/s²)."""
    positions = swaying((0.0, 0.0), seconds=seconds).values("marker_position")[:, :, 1:]
    time = np.arange(len(positions)) / RATE_HZ
    inside = (time >= 0.4) & (time < 0.5)
    belt_dd = np.where(inside, np.pi / 0.1 * 0.5 * np.cos(np.pi / 0.1 * (time - 0.4)), 0.0)
    speed = np.cumsum(belt_dd) / RATE_HZ
    return positions * 0.0 + positions[:1] + (np.cumsum(speed) / RATE_HZ)[:, None, None] * [1.0, 0.0], belt_dd


def test_soft_tissue_lags_behind_the_bone_below_its_marker():
    positions, belt_dd = pulsed()
    motion = tissue_motion(positions, list(LABELS), PERSON, belt_dd, 0.5, RATE_HZ)
    own = [LABELS.index(label) for label in PERSON.shank.labels if label not in PERSON.foot.labels]
    others = [k for k in range(len(LABELS)) if k not in own]
    # of markers that ride on the belt, as large as that of the belt
    assert np.abs(motion[:, own]).max() == pytest.approx(1.0, rel=0.02) and not motion[:, others].any()
    assert motion[100:110, own].min() < -0.1
    half = tissue_motion(positions, list(LABELS), PERSON, belt_dd, 0.25, RATE_HZ)
    assert half == pytest.approx(0.5 * motion)
    still = tissue_motion(np.tile(positions[:1], (500, 1, 1)), list(LABELS), PERSON, belt_dd, 0.5, RATE_HZ)
    assert not still.any()


def test_size_of_the_soft_tissue_is_found_from_the_markers():
    positions, belt_dd = pulsed()
    labels = list(LABELS)
    tissue = tissue_motion(positions, labels, PERSON, belt_dd, 0.5, RATE_HZ)[..., None] * [1.0, 0.0]
    still, unit = (
        relative_motion(positions + x * tissue, labels, PERSON, exclusive=True) for x in (0.0, 1e-3)
    )
    pattern, moved = (
        (unit - still) / 1e-3,
        relative_motion(positions + 8e-4 * tissue, labels, PERSON, exclusive=True),
    )
    size = tissue_from_pulses((moved - still)[None], pattern[None], np.zeros(2), 0.05)
    assert size == pytest.approx(8e-4, rel=1e-2)


# ---- the whole way, in an ideal laboratory -----------------------------------------------------------


@lru_cache(maxsize=1)
def ideal(stance=USUAL):
    trial = standing_trial(stance)
    standing = process_standing(trial, "ideal", OPTIONS, {"ankle": TorquePathway("ankle", None)}, {})
    epochs = cut_standing_epochs(standing, CUTTING)
    return (
        trial,
        standing,
        epochs,
        cut_broadband(standing, epochs, OPTIONS, CUTTING, WIDE, {}),
    )


@lru_cache(maxsize=1)
def smooth():
    return ideal.__wrapped__(Smooth())[3]


def fitted(broadband, window_s=0.08, sources=()):
    return fit_free_reflex([broadband], window_s, FREE, list(sources))


@pytest.mark.slow
@pytest.mark.parametrize("window_s", [0.05, 0.08])
def test_ideal_laboratory_returns_its_truth(window_s):
    fit = fitted(ideal()[3], window_s)
    assert fit.parameters == pytest.approx([DAMPING, STIFFNESS], rel=4e-3)


@dataclass(frozen=True)
class Smooth(Stance):
    """Pulses whose acceleration begins at 0: what is sampled at 250 Hz holds all of it."""

    def belt(self, time):
        omega, scale = 2.0 * np.pi / self.pulse_s, self.peak_m_per_s / 1.299
        phases = np.clip(omega * (np.ravel(time) - np.array(self.onsets_s)[:, None]), 0.0, 2.0 * np.pi)
        c, s = np.cos(phases), np.sin(phases)
        parts = (1.0 - c) ** 2 / (2.0 * omega), s * (1.0 - c), omega * (c - np.cos(2.0 * phases))
        return [scale * part.sum(axis=0).reshape(np.shape(time)) for part in parts]

    def belt_acceleration(self, t):
        return float(self.belt(t)[2])


@pytest.mark.slow
@pytest.mark.parametrize("window_s", [0.04, 0.06, 0.08])
def test_smooth_pulses_return_the_truth_to_a_thousandth(window_s):
    fit = fitted(smooth(), window_s)
    assert fit.parameters == pytest.approx([DAMPING, STIFFNESS], rel=1e-3)


def test_slopes_are_those_of_the_torque():
    _, standing, epochs, broadband = ideal()
    assert set(broadband.slopes) == set(SOURCES) and broadband.draws.shape == (0, broadband.time.size)
    # an ankle 5 mm further forward: the same by moving all markers of the analysis back
    moved = {
        name: replace(getattr(PERSON, name), layout_m=getattr(PERSON, name).layout_m - [0.005, 0.0])
        for name in ("foot", "shank")
    }
    options = replace(OPTIONS, person=replace(PERSON, **moved, foot_com_m=PERSON.foot_com_m - 0.005))
    other = cut_broadband(standing, epochs, options, CUTTING, WIDE, {})
    # there the centre of quiet sway corrects what is wrong
    assert other.centre.offset_m == pytest.approx((-0.005, 0.0), abs=1e-4) and other.centre_used
    assert fitted(other).parameters == pytest.approx(fitted(broadband).parameters, rel=2e-3)
    u = 0.01
    contribution = fitted(broadband, sources=[Source("force_scale", u), Source("moment_scale", u)]).budget
    assert 0.0 < contribution.of_source("force_scale")[1] < 0.1 * STIFFNESS


def test_epochs_come_back_from_their_file(tmp_path):
    broadband = ideal()[3]
    write_result(tmp_path / "epochs.h5", joined(broadband_result(broadband)))
    read = broadband_of(read_result(tmp_path / "epochs.h5"))
    assert read.perturbed == pytest.approx(broadband.perturbed, abs=1e-4)
    assert read.centre.offset_m == pytest.approx(broadband.centre.offset_m)
    assert (read.skin_m, read.carried_kg) == (broadband.skin_m, broadband.carried_kg)
    assert broadband_of(replace(read_result(tmp_path / "epochs.h5"), facts={})) is None
