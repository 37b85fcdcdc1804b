"""Compact tables and schematics of the report: numbers known by hand."""

import io
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import typst
from matplotlib import font_manager
from pypdf import PdfReader
from typst_builders import REPORT, by_typesetter, evaluated

from tepsipe.drawing import style
from tepsipe.drawing.names import PARAMETER_SETS, short_name
from tepsipe.drawing.style import in_style
from tepsipe.io.trial import Signal, Trial
from tepsipe.reporting.figures import TimeLine, draw_protocol, markers_at_rest

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
    asked = ["joint-rows()", "other-rows()"]
    (at_work, small), others = evaluated(asked, "recovery_values.typ", {"units": {}}, tables)
    assert (at_work["K"]["truth"], at_work["K"]["error"], at_work["K"]["covered"]) == (
        "8.00 to 10.0",
        "5.0",
        "1 of 2",
    )
    assert at_work["B"]["error"] == f"< {MINUS}1000"
    assert at_work["I"]["covered"] == ""
    assert small["small"] and small["K"]["error"] == "5.0"
    assert [(r["quantity"], r["error"]) for r in others] == [("mass", f"{MINUS}5.0")]


def test_markers_of_a_rig_are_where_the_trial_has_them_at_rest():
    position = np.zeros((400, 3, 3))
    position[:, :, 1], position[:, :, 2] = [0.30, np.nan, 0.36], [0.05, 0.20, 0.40]
    position[250:, :, 1] += 9.0  # the perturbation comes after the rest
    axes = {"marker": np.array(["ankle", "hidden", "leg1"]), "axis": np.array(["x", "y", "z"])}
    signals = {"marker_position": Signal(position, "m", ("time", "marker", "axis"))}
    found = markers_at_rest(Trial(100.0, {"time": np.arange(0.0, 4.0, 0.01)} | axes, signals))
    assert found == [pytest.approx((1, 0.0, 0.05)), pytest.approx((3, 0.06, 0.40))]


def test_protocol_has_a_tick_at_every_onset():
    lines = {"dummy": [TimeLine("S5", 60.0, [6.0, 10.0], 0.5)], "weight": [TimeLine("S1", 60.0, [6.0], -0.1)]}
    figure = draw_protocol(lines)
    ticks = [c.get_segments() for axis in figure.axes for c in axis.collections]
    assert [len(own) for own in ticks] == [2, 1]
    assert [float(s[0][0]) for s in ticks[0]] == [6.0, 10.0]
    height = [abs(own[0][1][1] - own[0][0][1]) for own in ticks]
    assert height[0] == pytest.approx(5.0 * height[1])


GEOMETRY = {"foot_height_m": 0.055, "leg_com_m": 0.45, "leg_mass_kg": 0.4, "leg_inertia_kgm2": 0.027}
GEOMETRY["foot_mass_kg"] = 2.1
MARKERS = [(1, 0.0, 0.05), (2, 0.001, 0.05), (4, 0.06, 0.4)]
RIGS = {"geometry": GEOMETRY, "person": {"stature_m": 1.75}, "mass_kg": 20.0}
ALL_RIGS = RIGS | {"markers": dict.fromkeys(("wristalyzer", "dummy", "weight", "standing"), MARKERS)}
METHODS = ["wristalyzer", "dummy", "simulation", "weight", "empty", "standing"]
CHAIN = {"plate_rate_hz": 250.0, "sampling_hz": 2500.0, "cutoff_hz": 20.0, "emg": True}
SETS = list(PARAMETER_SETS.values())
# a drawing, what the run gives it, words in it, and words that are not in it
DRAWINGS = (
    ("1_1", {}, "joint impedance|prior knowledge|not good: revise|recorded data|use it", ""),
    ("1_3", {"methods": METHODS}, "frequency domain: admittance|parameters to simulate|pilot data", ""),
    ("1_3", {"methods": ["dummy", "standing"]}, "Treadmill dummy|Treadmill person", "Wristalyzer|parameters"),
    ("rigs", ALL_RIGS, "leg: 0.4 kg, 0.027 kg·m²|foot: 2.1 kg|20 kg|1, 2|4|A TA|E RF|torque transducer", ""),
    ("rigs", RIGS | {"markers": {"dummy": MARKERS}}, "Dummy on the belt", "Wristalyzer|Person|Weight"),
    ("signal_chain", CHAIN, "one after another at 2500 Hz|at 250 Hz:|low-pass, 20 Hz|EDF|C3D", ""),
    ("signal_chain", CHAIN | {"sampling_hz": None, "emg": False}, "all at one instant|C3D", "EMG|EDF"),
    ("free_bodies", {}, "Leg|Foot|(plate)", ""),
    ("2_10", {"geometry": GEOMETRY}, "leg: 0.4 kg, 0.027 kg·m²|foot: 2.1 kg, slides|recorded motion", ""),
    ("2_11", {"sets": SETS, "trials": 12}, "|".join(["12 trials on the treadmill", *SETS]), ""),
    ("2_12", {"snr_db": [0, 60], "draws": 200, "cutoff_hz": 20.0}, "0 to 60 dB, 200 draws|pass 20 Hz", ""),
)


@pytest.mark.parametrize(("name", "run", "shown", "hidden"), DRAWINGS)
def test_a_drawing_has_its_labels_and_its_boxes_hold_their_words(name, run, shown, hidden):
    spare = """#show box: it => if it.height == auto { it } else { it; context {
        let (size, words) = ((it.width, it.height), measure(it.body.body).values())
        [#metadata(size.zip(words).map(((whole, part)) => (whole.length - part).pt())) <spare>]
    } }"""
    main = f'#import "/drawings.typ": *\n#show: drawing\n{spare}\n#figure_{name}(json(bytes(sys.inputs.run)))'
    given = {"root": str(REPORT), "sys_inputs": {"run": json.dumps(run)}, "ignore_system_fonts": True}
    pdf = by_typesetter(typst.compile, main.encode(), format="pdf", **given)
    (page,) = PdfReader(io.BytesIO(pdf)).pages
    words = " ".join(page.extract_text().split())
    assert [label for label in shown.split("|") if label not in words] == []
    assert [label for label in hidden.split("|") if label and label in words] == []
    boxes = [
        own["value"] for own in json.loads(by_typesetter(typst.query, main.encode(), "<spare>", **given))
    ]
    assert bool(boxes) == (run.keys().isdisjoint({"geometry"}) and name != "free_bodies")
    assert [own for own in boxes if min(own) < 2.0] == []


def test_figures_keep_their_font_where_the_users_list_of_fonts_lacks_it(monkeypatch):
    manager = font_manager.fontManager
    own = ("STIX", "Libertinus")
    monkeypatch.setattr(manager, "ttflist", [f for f in manager.ttflist if not f.name.startswith(own)])
    found = in_style(lambda: Path(font_manager.findfont(font_manager.FontProperties())).name)()
    assert found == "LibertinusSerif-Regular.otf"
    assert {"STIXGeneral", "Libertinus Serif"} <= {font.name for font in manager.ttflist}


def test_no_lettering_of_a_figure_is_too_small_to_read_in_print():
    """Figures are as wide as the text, so a size in the code is at most 3 % smaller than in print."""
    library = Path(style.__file__).parents[1]
    pattern = re.compile(r"\b(?:fontsize|title_fontsize|labelsize|size)=(\d+\.?\d*)\b(?! \*)")
    modules = [*library.glob("drawing/*.py"), *library.rglob("figures.py")]
    sizes = {str(p): [float(x) for x in pattern.findall(p.read_text("utf-8"))] for p in modules}
    assert sum(map(len, sizes.values())) > 20
    small = {name: [x for x in own if 5.0 < x < 7.0] for name, own in sizes.items()}
    assert {name: own for name, own in small.items() if own} == {}
    drawings = (REPORT / "drawings.typ").read_text("utf-8")
    assert min(map(float, re.findall(r"(?:\bsize: |text\()([\d.]+)pt", drawings))) >= style.SMALLEST_PT >= 7.0
    chapters = "".join(p.read_text("utf-8") for p in REPORT.rglob("*.typ"))
    assert not re.findall(r"#?shown\([^)\n]*width: [1-9]?[0-9]%", chapters)
