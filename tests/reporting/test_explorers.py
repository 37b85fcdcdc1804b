"""Figures to try: the page's leg moves as the library's, and every printed cell shows its verdict."""

import json
import math
import re
import shutil
import subprocess
from html import unescape

import numpy as np
import pytest
from builders import LEG, belt_pulses
from page_builders import NASTY, parsed

from tepsipe.drawing.trial_page import Packed, asset, unpack
from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS, Specification
from tepsipe.io.estimates import Estimate, Recovery
from tepsipe.io.result import Result
from tepsipe.mechanics.forward_dynamics import Joint, Start, resting, simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.reporting.claims import ClaimVerdict
from tepsipe.reporting.ledger import VERDICTS, CellVerdict
from tepsipe.reporting.page_parts import MEANINGS, SIGNS, explored, forward, ledger_table, printed_cells
from tepsipe.reporting.report_page import FILTERS

NODE = shutil.which("node")
RATE_HZ, STANDING_RAD = 250.0, 0.004
TIME = np.arange(2500) / RATE_HZ
VELOCITY = belt_pulses(TIME, (1.0, 5.0), 0.5)[1]
LINEAR = Joint(0.007, 0.08, 9.0)
SOFT = Joint(
    0.007, 0.065, 10.2, softening_Nm_per_rad=5.1, softened_damping_Nms_per_rad=0.13, half_softening_rad=0.025
)
GEOMETRY = {
    "leg_mass_kg": LEG.mass_kg,
    "leg_com_m": LEG.com_m,
    "leg_inertia_kgm2": LEG.inertia_kgm2,
    "gravity_m_per_s2": LEG.gravity_m_per_s2,
}


def fit(**joints):
    """Fit of a forward simulation, with a recorded angle that no joint explains."""
    arrays = {
        "time": TIME,
        "theta": np.sin(TIME),
        "foot_velocity": VELOCITY,
        "windows": np.array([[250, 290]]),
    }
    facts = {"standing_rad": STANDING_RAD, "joints": joints, "softens": ["joint-likelihood"]}
    return Result(arrays, {}, facts)


def constants(joint, *names):
    return {name: getattr(joint, name) for name in names}


def in_the_page(given, joint):
    """Angle (rad) that the page's script integrates."""
    script = f"{asset('swing.js')}const [l, j, r, v, s] = JSON.parse(require('fs').readFileSync(0));"
    script += "console.log(JSON.stringify([...swing(l, j, r, v, s).angle]));"
    content = json.dumps([given["leg"], joint, given["rate"], VELOCITY.tolist(), given["standing"]])
    done = subprocess.run([NODE, "-e", script], input=content, capture_output=True, text=True, timeout=60)
    assert done.stderr == ""
    return np.array(json.loads(done.stdout), dtype=float)


@pytest.mark.skipif(NODE is None, reason="no node: the page's script is not compared with the library")
def test_leg_of_the_page_swings_as_the_library_simulates_it():
    linear = ("inertia_Nms2_per_rad", "damping_Nms_per_rad", "stiffness_Nm_per_rad", "rest_angle_rad")
    softening = ("softening_Nm_per_rad", "softened_damping_Nms_per_rad", "half_softening_rad")
    joints = {
        "corrected": constants(LINEAR, *linear),
        "joint-likelihood": constants(SOFT, *linear, *softening),
    }
    given = forward(fit(**joints), "sine-0.5", GEOMETRY, [])
    names = [own.pop("name") for own in given["sets"]]
    assert names == ["joint likelihood", "TEP-SIPE, consistent"]
    for joint, own in zip((SOFT, LINEAR), given["sets"], strict=True):
        expected = simulate_dummy(
            TIME,
            VELOCITY,
            LEG,
            Foot(2.1, 0.055),
            resting(LEG, joint, STANDING_RAD),
            0.001,
            "equations",
            Start(STANDING_RAD, 0.0),
        ).theta
        assert np.ptp(expected) > 0.04
        assert np.abs(in_the_page(given, own) - expected).max() < 1e-3 * np.ptp(expected)


@pytest.mark.skipif(NODE is None, reason="no node: the page's script is not compared with the library")
def test_leg_of_the_page_falls_on_a_joint_that_cannot_hold_it():
    given = forward(fit(), "sine-0.5", GEOMETRY, [])
    angle = in_the_page(given, {"I": 0.007, "B": 0.05, "K": 1.0})
    assert np.isnan(angle[-1]) and np.nanmax(np.abs(angle)) < 0.5 * np.pi


def test_recording_reaches_the_page_in_its_units():
    given = forward(fit(), "sine-0.5", GEOMETRY, [])
    assert np.allclose(unpack(Packed(**given["velocity"])), VELOCITY, atol=1e-5)
    assert np.allclose(unpack(Packed(**given["angle"])), np.sin(TIME), atol=1e-4)
    assert given["windows"] == [[250, 290]] and given["truth"] is None and given["condition"] == "S5"
    json.dumps(given, allow_nan=False)


def cell(table="table_4_2", row="K", column="sine-0.1", **changed):
    given = {"reported": 10.0, "value": 10.21, "tolerance": "0.3", "verdict": "predicted", "reason": "why"}
    given |= {"null_value": 9.5, "null_verdict": "not reproduced"}
    return CellVerdict(table, row, column, **(given | changed))


def test_every_printed_cell_has_sign_colour_and_reason():
    others = [
        cell(row="SEM_K", column=c, verdict=v) for c, v in (("sine-0.1", "fitted"), ("sine-0.2", "unknown"))
    ]
    cells = [cell(), cell(table="table_4_4", column="tau", value=None, null_verdict="implied", reason=NASTY)]
    html = printed_cells([*cells, *others])
    words = " ".join(parsed(html).words)
    assert html.count('<td class="v-') == 4 and len(set(SIGNS.values())) == len(VERDICTS)
    first = html.partition('<td class="v-predicted"')[2].partition("</td>")[0]
    assert "printed: 10\nthis run: 10.210\ntolerance: 0.3\nverdict: predicted" in first
    assert (
        "null model: 9.500, not within\nreason: why" in first and ">10 <b>p</b><small>10.2</small>" in first
    )
    assert "Table 4-2 of the thesis" in words and "S1" in words and "noise on τ" in words and "p∗" in words
    # the column without a printed number has an empty cell
    assert html.count("<td></td>") == 3


def claim(**changed):
    given = dict.fromkeys(("claim", "where", "unit", "tolerance", "section", "used", "statements"), "")
    given |= {
        "claim": "K of all",
        "unit": "Nm/rad",
        "reported": 9.996,
        "reproduced": 9.4181,
        "tolerance": "0.3",
    }
    given |= {"verdict": "not reproduced", "section": "The joint", "null_value": 9.9958, "margin": None}
    given |= {"null_verdict": "implied", "used": "a joint; our threshold, the thesis prints none"}
    return ClaimVerdict(**(given | {"statements": "1;3", "measure": "m", "reason": ""} | changed))


def test_the_ledger_has_every_claim_cell_and_untested_statement_once():
    says = [{"where": f"Section {k}", "says": f"Statement {k}."} for k in range(1, 6)]
    says[1] |= {"unchecked": f'no measure {NASTY} (Section "A rod")'}
    says[3] |= {"tables": ["table_4_2"]}
    claims = [claim(), claim(claim="No", statements="", verdict="pattern", tolerance="below")]
    claims += [claim(claim="One", statements="", reason="a taper: 0.45", verdict="explained")]
    html = ledger_table(says, claims, [cell(null_verdict="implied", reason="why; used: a rod")])
    rows = [re.sub(r"<[^>]+>", " ", row) for row in re.findall(r"(?s)<tr data-kind=.*?</tr>", html)]
    assert re.findall('<tr data-kind="(.*?)" data-verdict="(.*?)">', html) == [
        ("claim", "not reproduced"),
        ("untested", "not tested"),
        ("untested", "tested by cells"),
        ("claim", "pattern"),
        ("claim", "explained"),
        ("cell", "predicted"),
    ]
    assert "Statement 1. Statement 3.  We test: K of all (N·m/rad)" in rows[0]
    assert "9.996  ± 0.3 our threshold" in rows[0] and "9.4181  9.9958∗" in rows[0]
    assert 'See <a href="#section:The joint">The joint</a>.' in html and "< 9.996" in unescape(rows[3])
    assert '(<a href="#section:A rod">A rod</a>)' in html and html.count("section:The joint") == 1
    assert "A taper: 0.45." in rows[4]
    assert "Statement 2." in rows[1] and "Statement 4." in rows[2] and "cells of Table 4-2" in rows[2]
    assert "10  tolerance 0.3" in rows[5] and " 10.2 " in rows[5] and "Why." in rows[5]
    # what the numbers rest on is listed once, and named by its number
    assert re.findall(r'<li id="basis-\d">(.*?)</li>', html) == ["A joint.", "A rod."]
    assert html.count('href="#basis-1"') == 3 and html.count('href="#basis-2"') == 1
    assert "within tolerance for 2 of these 4 numbers" in html.replace("\n", " ")
    parsed(html)
    assert "nan" not in ledger_table([], [], [cell(value=math.nan)])
    assert set(MEANINGS) == {*VERDICTS, "tested by cells", "not tested"}
    assert html.count("</b> tested by cells</span></dt>") == html.count("</b> not tested</span></dt>") == 1


def test_a_choice_of_a_filter_is_an_attribute_of_rows():
    html = ledger_table([], [claim()], [cell(), cell(verdict="fitted")])
    for name in ("kind", "verdict"):
        choices = html.partition(f'<select name="{name}">')[2].partition("</select>")[0]
        values = re.findall('value="([^"]+)"', choices)
        assert set(re.findall(f'data-{name}="([^"]+)"', html)) <= set(values)
    assert FILTERS["ledger"].partition("=")[2] in values


def test_the_curve_shows_the_recommended_estimate_beside_the_combinations(tmp_path):
    path = tmp_path / "specification.csv"
    row = Specification("a", *["x"] * 6, "recommended", 0.01, 0.1, 9.48, 99.0)
    SPECIFICATIONS.write(path, [row])
    names = ("dummy", "a", "leg", "joint-likelihood", "K", "Nm/rad")
    estimates = [Estimate(*names, 9.39, recommended=True), Estimate(*names, 1.0)]
    truth = [Recovery(*names, 9.25, 9.39, 0.01, True, "", True), Recovery(*names, 1.0, 1.0, 0.0, True, "")]
    shown = explored(GEOMETRY, str(path), estimates, truth, {})["figure_specification"][1]
    assert shown["quoted"] == {"K": 9.39, "by": "joint likelihood"} and shown["truth"] == 9.25
    assert [row["role"] for row in shown["rows"]] == ["the consistent torque in the tables"]


def test_figures_to_try_need_what_they_show(tmp_path):
    path = tmp_path / "specification.csv"
    SPECIFICATIONS.write(path, [])
    assert explored(GEOMETRY, str(path), [], [], {}) == {}
    assert list(explored(GEOMETRY, str(path), [], [], {"sine-0.5": fit()})) == ["figure_4_7"]
