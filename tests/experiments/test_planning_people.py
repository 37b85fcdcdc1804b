"""Plans for people: a standing person's ankles against draws of the estimator, strides of a walking one."""

from dataclasses import replace

import numpy as np
import pytest

from tepsipe.cli import main
from tepsipe.errors import InputError
from tepsipe.experiments.planning.pulses import pulse_of
from tepsipe.experiments.planning.standing_plan import (
    BASELINE_S,
    BEFORE_S,
    OPTIONS,
    RATE_HZ,
    WINDOW_S,
    StandingDesign,
    baseline_samples,
    epoch_time,
    frame_effect,
    plan_standing,
    stationary_covariance,
)
from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.experiments.standing.free_reflex.fit import fit_free_reflex
from tepsipe.experiments.walking.needed_strides import NEEDED_ROWS, NeededRow
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass


def test_choices_of_the_estimator_are_those_of_the_study(shipped_config):
    chosen = shipped_config["standing"]["free_reflex"]
    assert vars(OPTIONS) == {**chosen, "windows_s": tuple(chosen["windows_s"])}


def angle_noise(design, shape, rng):
    """Noise of the cameras in angle and rate behind the low-pass, shape (*shape, 2) (rad, rad/s)."""
    size = design.angle_per_marker * design.marker_noise_m * np.sqrt(RATE_HZ / design.camera_rate_hz)
    wide = size * rng.standard_normal((shape[0], shape[1] + 80))
    wide = butterworth_lowpass(wide, RATE_HZ, design.cutoff_hz, 4, axis=1)
    rate = derivative(np.arange(wide.shape[1]) / RATE_HZ, wide.T).T
    return np.stack([wide, rate], axis=-1)[:, 40:-40]


def draw_standing_estimates(plan, rng, draws, quiet_s=1.12, more_torque=0.0):
    """B (N·m·s/rad) and K (N·m/rad) of simulated experiments by the estimator itself, shape (draws, 2).

    ``more_torque`` (N·m) is an error of the torque in every response.
    """
    time, design = epoch_time(), plan.design
    quiet_time = np.arange(round(quiet_s * RATE_HZ) + 1) / RATE_HZ
    roots = [
        np.linalg.cholesky(stationary_covariance(design, n) + 1e-9 * np.eye(n))
        for n in (time.size, quiet_time.size)
    ]
    found = np.empty((draws, 2))
    angle, rate = plan.response[:, 1:].T
    for k in range(draws):
        sway, quiet = (
            rng.standard_normal((count, len(root))) @ root.T
            for count, root in zip((design.number, 40), roots, strict=True)
        )
        perturbed = np.repeat(plan.response[None], design.number, axis=0)
        perturbed[:, :, 0] += more_torque
        perturbed[:, :, 0] += sway - sway[:, baseline_samples(time)].mean(axis=1, keepdims=True)
        still = np.zeros((*quiet.shape, 3))
        still[:, :, 0] = quiet
        for signals in (perturbed, still):
            noise = angle_noise(design, signals.shape[:2], rng)
            signals[:, :, 1:] += noise
        perturbed -= perturbed[:, baseline_samples(time)].mean(axis=1, keepdims=True)
        epochs = BroadbandEpochs(
            time=time,
            perturbed=perturbed,
            quiet_time=quiet_time,
            quiet=still,
            slopes={},
            draws=np.zeros((0, time.size)),
            # the belt turns the shank about a point: but for its size, the same motion
            belt=np.column_stack([rate, angle]),
            baseline_s=(-BEFORE_S, BASELINE_S - BEFORE_S),
            cutoff_hz=design.cutoff_hz,
            order=4,
            peak_m_per_s=plan.peak_m_per_s,
            carried_kg=80.0,
            calibrated_kg=None,
            centre=None,
            centre_used=False,
            apparent=None,
            skin_m=0.0,
        )
        fit = fit_free_reflex([epochs], WINDOW_S, design.options, [])
        found[k] = fit.parameters
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("noise_m", "rate_hz"), [(6.5e-6, 250.0), (3e-4, 200.0)])
def test_draws_of_sway_and_noise_scatter_as_predicted(noise_m, rate_hz):
    plan = plan_standing(StandingDesign(number=12, marker_noise_m=noise_m, camera_rate_hz=rate_hz))
    drawn = draw_standing_estimates(plan, np.random.default_rng(4), 30)
    # 30 draws determine a standard deviation to 13 %
    assert drawn.std(axis=0, ddof=1) == pytest.approx(plan.type_a[1:], rel=0.4)
    truth = plan.design.parameters[1:]
    assert (np.abs(drawn.mean(axis=0) - truth) < 0.02 * truth + plan.type_a[1:]).all()


@pytest.mark.slow
def test_what_the_model_leaves_of_the_frame_changes_the_estimates_as_predicted():
    plan = plan_standing(StandingDesign(frame_hz=35.0, frame_left=1.0, type_b=0.0))
    plain = draw_standing_estimates(plan, np.random.default_rng(4), 2).mean(axis=0)
    changed = [
        draw_standing_estimates(plan, np.random.default_rng(4), 2, more_torque=effect).mean(axis=0) - plain
        for effect in plan.of_frame.T
    ]
    assert np.sqrt(np.mean(np.square(changed), axis=0)) == pytest.approx(plan.type_b[1:], rel=0.3)


def test_uncertainty_follows_sway_size_and_number():
    options = replace(OPTIONS, discrepancy=1e-4, reflex_Nm=1e-3)
    base = StandingDesign(noise_Nm=1e-3, marker_noise_m=0.0, options=options)
    plan = plan_standing(base)
    twice = plan_standing(replace(base, sway_Nm=2.0 * base.sway_Nm))
    assert twice.type_a[1:] == pytest.approx(2.0 * plan.type_a[1:], rel=0.05)
    larger = plan_standing(
        replace(base, pulse=pulse_of("sine", 0.8, 0.1), drive=replace(base.drive, acceleration_m_per_s2=1e3))
    )
    unlimited = plan_standing(replace(base, drive=replace(base.drive, acceleration_m_per_s2=1e3)))
    assert larger.type_a[1:] == pytest.approx(0.5 * unlimited.type_a[1:], rel=0.05)
    assert plan.type_a_with(160)[1:] == pytest.approx(0.5 * plan.type_a_with(40)[1:], rel=0.05)


def test_number_is_the_smallest_that_is_enough():
    plan = plan_standing(StandingDesign(type_b=0.02))
    number = plan.number_for(0.06, "K")
    wanted = 0.06 * 400.0 / 1.959964
    assert plan.with_number(number)[2] <= wanted < plan.with_number(number - 1)[2]
    assert plan_standing(StandingDesign(type_b=0.06)).number_for(0.1, "K") is None
    with pytest.raises(InputError, match="above 0 for 'sway_s', found 0"):
        StandingDesign(sway_s=0.0)


def test_half_width_grows_as_the_frame_softens():
    stiff, shipped, soft = (
        plan_standing(StandingDesign(frame_hz=hz)).rows()[1] for hz in (2000.0, 52.0, 30.0)
    )
    others = np.hypot(stiff["predicted_u"], 0.072 * 400.0)
    assert stiff["u_combined"] == pytest.approx(others, rel=0.001)
    assert stiff["half_width_percent"] < shipped["half_width_percent"] < soft["half_width_percent"]
    # without a model of the treadmill the frame alone is worth more than everything else
    bare = plan_standing(StandingDesign(frame_hz=30.0, frame_left=1.0, type_b=0.0))
    assert bare.type_b[2] > 0.072 * 400.0
    assert bare.type_a[2] == pytest.approx(stiff["predicted_u"])


def test_slow_torque_passes_the_frame_as_its_acceleration_over_the_squared_frequency():
    time = np.arange(2000) / 1000.0
    slowly, w = 2.0 * np.pi * 2.0, 2.0 * np.pi * 50.0
    torque = 1.0 - np.cos(slowly * time)
    slow = frame_effect(torque, 50.0, 0.1)[500:]
    assert slow == pytest.approx(-((slowly / w) ** 2) * np.cos(slowly * time[500:]), abs=5e-5)


def test_commands_for_people(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["plan", "--experiment", "standing", "--number", "20"]) in (0, None)
    assert "20 responses of both ankles" in capsys.readouterr().out
    assert main(["plan", "--experiment", "standing", "--frame", "25"]) in (0, None)
    said = capsys.readouterr().out
    assert float(said.split("+-")[2].split()[0]) > 20.0 and "frame of 25 Hz" in said
    assert (tmp_path / "plan.csv").read_text().splitlines()[1].startswith("standing-sine,B,")
    counts = {20.0: 180.0, 40.0: 24.0, 60.0: 13.0, 80.0: 10.0}
    rows = [
        NeededRow("slow", p, kind, 5.0, 0.01, 100.0, 50.0, n, 1, 1.0)
        for kind in ("state", "mean")
        for p, n in counts.items()
    ]
    NEEDED_ROWS.write(tmp_path / "needed.csv", rows)
    (tmp_path / "walk.toml").write_text('experiment = "walking"\namplitude_deg = 3')
    main(["plan", "--design", "walk.toml", "--needed", "needed.csv"])
    said = capsys.readouterr().out
    cells = [line.split() for line in said.splitlines()[3:]]
    assert [int(row[3]) for row in cells] == [115, 15, 10, 10]
    assert int(cells[0][2]) == 45  # a quarter of the strides at twice the amplitude
    NEEDED_ROWS.write(tmp_path / "needed.csv", rows[4:])
    assert main(["plan", "--design", "walk.toml", "--needed", "needed.csv"]) == 2
    assert "needed.csv: expected strides needed at phases of stance, found none" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("design", "options", "words"),
    [
        ("", ["--experiment", "standing", "--optimise"], "expected no --optimise for a person"),
        ("lever = 0.9", ["--experiment", "standing"], "found 'lever': did you mean 'lever_m'?"),
        ("experiment = 'standing'\npulse = 1", [], "expected a known key, found 'pulse'"),
        ("type_b = 2", ["--experiment", "standing"], "own.toml: expected a number below 1 for 'type_b'"),
        ("", ["--experiment", "walking"], "own.toml: expected the key needed, found none"),
        ("", ["--experiment", "walking", "--needed", "none.csv"], "none.csv"),
        (
            "amplitude_deg = 0",
            ["--experiment", "walking", "--needed", "a.csv"],
            "a positive amplitude_deg",
        ),
        ("needed = 'a.csv'", ["--experiment", "walking", "--json"], "--json: expected a plan of the dummy"),
    ],
)
def test_what_cannot_be_planned_for_people(design, options, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(design)
    assert main(["plan", "--design", "own.toml", *options]) == 2
    assert words in capsys.readouterr().err
