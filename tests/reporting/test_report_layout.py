"""Compact tables and schematics of the report: numbers known by hand."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib import font_manager
from matplotlib.patches import FancyBboxPatch
from typst_builders import REPORT, evaluated

from tepsipe.io.trial import Signal, Trial
from tepsipe.reporting.figures import flow_charts, style
from tepsipe.reporting.figures.names import PARAMETER_SETS, short_name
from tepsipe.reporting.figures.protocol import TimeLine, draw_protocol
from tepsipe.reporting.figures.schematics import draw_rigs, rig_at_rest
from tepsipe.reporting.figures.style import in_style

MINUS = "\N{MINUS SIGN}"


@pytest.mark.parametrize(
    ("condition", "label"),
    [("sine-0.3-60kg", "S3, 60 kg"), ("negative-sine-0.5-60kg", f"{MINUS}S5, 60 kg"), ("sine-0.5-8s", "S52")],
)
def test_mass_and_direction_are_not_taken_for_an_interval(condition, label):
    assert short_name(condition) == label


def test_truth_and_estimates_share_a_row_for_each_pathway():
    def row(condition, quantity, truth, value, covered, of="the fitted windows"):
        return (
            "dummy",
            condition,
            "leg",
            "ls",
            quantity,
            "Nm/rad",
            truth,
            value,
            value / truth - 1,
            covered,
            of,
        )

    columns = ["experiment", "condition", "pathway", "estimator", "quantity", "unit"]
    columns += ["truth", "value", "relative_error", "covered", "truth_of"]
    frame = pd.DataFrame(
        [
            row("a", "K", 10.0, 11.0, "true"),
            row("b", "K", 8.0, 8.0, "false"),
            row("a", "B", 0.1, -5.0, "false"),
            row("a", "K_small", 12.0, 12.6, "true", "small movements"),
            row("a", "mass", 20.0, 19.0, "true", "small movements"),
        ],
        columns=columns,
    )
    tables = {"recovery": frame.to_csv(index=False)}
    asked = ["joint-rows()", "other-rows()", "has-windows()"]
    (at_work, small), others, windows = evaluated(asked, "recovery_values.typ", {"units": {}}, tables)
    assert (at_work["K"]["truth"], at_work["K"]["error"], at_work["K"]["covered"]) == (
        "8.00 to 10.0",
        "5.0",
        "1 of 2",
    )
    assert at_work["B"]["error"] == f"< {MINUS}1000"
    assert at_work["I"]["covered"] == ""
    assert small["small"] and small["K"]["error"] == "5.0"
    assert [(r["quantity"], r["error"]) for r in others] == [("mass", f"{MINUS}5.0")]
    assert windows


def test_markers_are_drawn_where_the_trial_has_them_at_rest():
    time = np.arange(0.0, 4.0, 0.01)
    position = np.zeros((400, 2, 3))
    position[:, :, 1], position[:, :, 2] = [0.30, 0.36], [0.05, 0.40]
    position[250:, :, 1] += 9.0  # the perturbation comes after the rest
    trial = Trial(
        100.0,
        {"time": time, "marker": np.array(["ankle", "leg1"]), "axis": np.array(["x", "y", "z"])},
        {"marker_position": Signal(position, "m", ("time", "marker", "axis"))},
    )
    rig = rig_at_rest(trial)
    assert rig.points == pytest.approx(np.array([[0.30, 0.05], [0.36, 0.40]]))
    assert rig.ankle == pytest.approx([0.30, 0.05])
    geometry = {
        "foot_height_m": 0.055, "leg_com_m": 0.45, "leg_mass_kg": 0.4, "leg_inertia_kgm2": 0.027,
        "foot_mass_kg": 2.1,
    }  # fmt: skip
    figure = draw_rigs({"dummy": rig, "wristalyzer": None}, geometry, {"stature_m": 1.75}, 20.0)
    dummy = figure.axes[1]
    drawn = dummy.lines[0].get_xydata()
    assert drawn == pytest.approx(np.array([[0.0, 0.05], [0.06, 0.40]]))


def test_protocol_has_a_tick_at_every_onset():
    lines = {"dummy": [TimeLine("S5", 60.0, [6.0, 10.0], 0.5)], "weight": [TimeLine("S1", 60.0, [6.0], -0.1)]}
    figure = draw_protocol(lines)
    ticks = [c.get_segments() for axis in figure.axes for c in axis.collections]
    assert [len(own) for own in ticks] == [2, 1]
    assert [float(s[0][0]) for s in ticks[0]] == [6.0, 10.0]
    height = [abs(own[0][1][1] - own[0][0][1]) for own in ticks]
    assert height[0] == pytest.approx(5.0 * height[1])


CHAIN = {"plate_rate_hz": 250.0, "sampling_hz": 2500.0, "cutoff_hz": 20.0, "emg": True}
CHARTS = {
    "identification": flow_charts.draw_identification,
    "all methods": lambda: flow_charts.draw_methods(list(flow_charts.METHODS)),
    "methods without the Wristalyzer": lambda: flow_charts.draw_methods(["dummy", "standing"]),
    "signals": lambda: flow_charts.draw_signal_chain(CHAIN),
    "signals without EMG": lambda: flow_charts.draw_signal_chain(CHAIN | {"sampling_hz": None, "emg": False}),
    "evaluation": lambda: flow_charts.draw_evaluation(list(PARAMETER_SETS.values()), 12),
    "sensitivity": lambda: flow_charts.draw_sensitivity({"snr_db": [0, 60], "draws": 200, "cutoff_hz": 20.0}),
}


@pytest.mark.parametrize("name", CHARTS)
def test_words_of_a_flow_chart_are_legible_and_inside_their_boxes(name):
    figure = CHARTS[name]()
    figure.draw_without_rendering()
    (axis,) = figure.axes
    renderer = figure.canvas.get_renderer()
    boxes = [p.get_window_extent(renderer) for p in axis.patches if isinstance(p, FancyBboxPatch)]
    whole = figure.bbox
    for text in axis.texts:
        words = text.get_text()
        if not words:
            continue
        assert text.get_fontsize() >= 7.5, words
        own = text.get_window_extent(renderer)
        assert whole.x0 <= own.x0 and own.x1 <= whole.x1, words
        assert whole.y0 <= own.y0 and own.y1 <= whole.y1, words
        for box in boxes:
            if box.overlaps(own):
                assert box.x0 <= own.x0 and own.x1 <= box.x1, words
                assert box.y0 <= own.y0 and own.y1 <= box.y1, words


def test_figures_keep_their_font_where_the_users_list_of_fonts_lacks_it(monkeypatch):
    manager = font_manager.fontManager
    own = ("STIX", "Libertinus")
    monkeypatch.setattr(manager, "ttflist", [f for f in manager.ttflist if not f.name.startswith(own)])
    found = in_style(lambda: Path(font_manager.findfont(font_manager.FontProperties())).name)()
    assert found == "LibertinusSerif-Regular.otf"
    assert {"STIXGeneral", "Libertinus Serif"} <= {font.name for font in manager.ttflist}


def test_no_lettering_of_a_figure_is_too_small_to_read_in_print():
    """Figures are as wide as the text, so a size in the code is at most 3 % smaller than in print."""
    folder = Path(style.__file__).parent
    pattern = re.compile(r"\b(?:fontsize|title_fontsize|labelsize|size)=(\d+\.?\d*)\b(?! \*)")
    sizes = {p.name: [float(x) for x in pattern.findall(p.read_text("utf-8"))] for p in folder.glob("*.py")}
    assert sum(map(len, sizes.values())) > 20
    small = {name: [x for x in own if 5.0 < x < 7.0] for name, own in sizes.items()}
    assert {name: own for name, own in small.items() if own} == {}
    assert style.SMALLEST_PT >= 7.0
    chapters = "".join(p.read_text("utf-8") for p in REPORT.rglob("*.typ"))
    assert not re.findall(r"#?shown\([^)\n]*width: [1-9]?[0-9]%", chapters)
