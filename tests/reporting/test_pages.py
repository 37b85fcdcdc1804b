"""Pages of trials: what they show, that they load nothing, and that no text of a user can break them."""

import json
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from page_builders import (
    NASTY,
    RATE_HZ,
    attributes,
    estimates_of,
    leg_result,
    page_data,
    parsed,
    standing_results,
    treadmill_trial,
    weight_results,
)

from tepsipe.drawing import header, trial_page
from tepsipe.drawing.names import below_100, by_uncertainty
from tepsipe.drawing.trial_page import (
    Band,
    Clock,
    Page,
    Panel,
    Section,
    Trace,
    asset,
    json_script,
    render,
    write_page,
)
from tepsipe.experiments.belt.page import belt_page
from tepsipe.experiments.dummy.page import dummy_page
from tepsipe.experiments.position_manipulator.page import position_manipulator_page
from tepsipe.experiments.standing.page import standing_page
from tepsipe.experiments.weight.page import weight_page
from tepsipe.experiments.wristalyzer.page import wristalyzer_page
from tepsipe.io.result import Result
from tepsipe.io.trial import Signal, Trial


def dummy(study="A study", condition="sine-0.3", trial=None, foot=True, flags=""):
    trial = trial or treadmill_trial()
    size = trial.time.size
    return dummy_page(
        trial,
        leg_result(size),
        leg_result(size, ("foot",), loads=True) if foot else None,
        estimates_of(condition=condition, flags=flags),
        {"study": study, "condition": condition, "belt": "right", "recommended": "leg", "made": False},
    )


def weight(study="A study", condition="minjerk-0.5"):
    fit, plate = weight_results()
    choices = {"study": study, "experiment": "weight", "condition": condition, "role": "validate"}
    return weight_page(treadmill_trial(), fit, plate, [], choices | {"belt": "right", "made": True})


def standing(study="A study", condition="relax"):
    trial = treadmill_trial(emg=True)
    reasons = [f"standing/{condition}: perturbation at 8.00 s left out: marker 'foot1' was hidden"]
    choices = {"study": study, "condition": condition, "task": "relax", "belt": "right", "made": True}
    recommended = {"recommended": ["leg", "windowed-least-squares"]}
    return standing_page(
        trial, *standing_results(trial, reasons), estimates_of("standing", condition), choices | recommended
    )


def manipulator_trial(*names):
    time = np.arange(3000) / RATE_HZ
    signals = {name: Signal(np.sin(3.0 * time), "Nm") for name in names}
    return Trial(RATE_HZ, {"time": time}, signals, attributes("a.txt"))


def wristalyzer(study="A study", condition="0.16"):
    trial = manipulator_trial("torque", "angle")
    arrays = {key: np.cos(trial.time) for key in ("torque", "angle", "predicted_angle")}
    facts = {
        "kept_samples": [500, 2500],
        "converged": {"spectral-fit": False},
        "at_bound": {"spectral-fit": True},
    }
    choices = {"study": study, "condition": condition, "made": False}
    return wristalyzer_page(trial, Result(arrays, {}, facts), estimates_of("wristalyzer", condition), choices)


def position_manipulator(study="A study", condition="trial1"):
    trial = manipulator_trial("torque", "angle")
    used = slice(250, 2750)
    arrays = {"time": trial.time[used]}
    for key in ("angle", "torque", "predicted_torque", "reflex/predicted_torque"):
        arrays[key] = np.cos(trial.time[used])
    facts = {"held_out_from_s": 6.0, "training_s": 5.0, "vaf_held_out_percent": 80.0}
    facts["reflex"] = {"vaf_held_out_percent": 93.0}
    choices = {"study": study, "condition": condition, "made": False}
    return position_manipulator_page(trial, Result(arrays, {}, facts), [], choices)


def belt(study="A study", condition="fast"):
    trial = manipulator_trial("belt_velocity", "load")
    arrays = {f"{condition}/{key}": np.cos(trial.time[500:1000]) for key in ("measured", "fir", "hnat2014")}
    arrays[f"{condition}/time"] = trial.time[500:1000]
    facts = {"models": ["fir", "hnat2014"], "rate_hz": RATE_HZ, "cutoff_hz": 6.0}
    choices = {
        "study": study,
        "condition": condition,
        "role": "validate",
        "chosen": "hnat2014",
        "made": False,
    }
    return belt_page(trial, Result(arrays, {}, facts), choices)


PAGES = {f.__name__: f for f in (dummy, weight, standing, wristalyzer, position_manipulator, belt)}


@pytest.mark.parametrize("make", PAGES.values(), ids=PAGES)
def test_page_is_one_file_that_loads_nothing(make):
    html = render(make())
    reader = parsed(html)
    assert reader.links == []
    assert len(reader.scripts) == 3
    assert "default-src 'none'" in html.replace("&#x27;", "'")
    for outside in ("http:", "https:", "//cdn", "@import", "url(", "fetch(", "XMLHttpRequest", "import("):
        assert outside not in html
    assert len(html.encode()) < 1_000_000
    data = json.loads(reader.scripts[1])
    assert len(data["panels"]) == html.count('<figure class="panel"')
    assert all(panel["traces"] and panel["axis"] in data["axes"] for panel in data["panels"])


@pytest.mark.parametrize("make", PAGES.values(), ids=PAGES)
def test_same_content_gives_the_same_bytes(make, tmp_path):
    for name in ("a", "b"):
        write_page(tmp_path / name, make())
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("make", PAGES.values(), ids=PAGES)
def test_no_title_or_condition_can_break_a_page(make):
    html = render(make(study=NASTY, condition=NASTY))
    reader = parsed(html)
    assert len(reader.scripts) == 3
    assert "alert(1)" not in reader.scripts[2]
    assert "<b> " not in html and "<!--" not in html
    assert NASTY in "".join(reader.words)


def test_names_of_markers_and_files_are_escaped():
    trial = treadmill_trial(markers=("</script>", "<img src=x>"), name="<i>.mat")
    reader = parsed(render(dummy(trial=trial)))
    labels = [t["label"] for panel in json.loads(reader.scripts[1])["panels"] for t in panel["traces"]]
    assert "</script>" in labels and "<img src=x>" in labels
    assert reader.links == []
    assert "raw/<i>.mat" in reader.words


def test_no_text_ends_the_data_of_a_page():
    script = json_script("data", {"a": f"{NASTY}<!--<script>"})
    assert script.count("<") == 2 and "\u2028" not in script
    assert json.loads(parsed(script).scripts[0])["a"].startswith("</script>")


def test_page_of_a_long_recording_with_many_traces_stays_below_a_megabyte(rng):
    time = np.arange(600_000) / 1000.0
    clock = Clock.of(time, [(t, t + 0.5) for t in range(0, 600, 4)])
    x = rng.normal(size=time.size)
    x[123_456] = 99.0
    panels = tuple(Panel(f"p{k}", "N", tuple(Trace(str(j), x, clock) for j in range(8))) for k in range(8))
    html = render(Page("long", "study", "", (Section("all", panels),)))
    assert len(html) < 1_000_000
    for trace in page_data(html)["panels"][0]["traces"]:
        assert trace["offset"] + 32767 * trace["scale"] == pytest.approx(99.0)


def test_short_traces_leave_their_points_to_long_ones(monkeypatch):
    monkeypatch.setattr(trial_page, "MOST_POINTS", 1_000)
    assert trial_page._points([100, 100, 5_000, 9_000]) == 400
    assert trial_page._points([100, 100]) == 900
    assert trial_page._points([]) == 0
    assert trial_page._points([5_000] * 10) == 100


def test_dummy_shows_belt_markers_forces_angle_and_torque_of_every_pathway():
    data = page_data(render(dummy()))
    panels = {panel["title"]: [t["label"] for t in panel["traces"]] for panel in data["panels"]}
    assert panels["Belt velocity"] == ["measured", "command"]
    assert panels["Markers along the belt"] == ["foot1", "leg1"]
    before_after = ["measured", "compensated, treadmill model loaded-frame"]
    assert panels["Fore-aft force before and after compensation"] == before_after
    assert panels["Torque, leg"] == panels["Torque, foot"] == ["torque", "predicted"]
    assert [w[1:3] for w in data["axes"]["time"]["windows"]] == [[4.0, 4.12], [8.0, 8.12]]
    (hidden,) = [b for p in data["panels"] for b in p["bands"] if b[0] == "hidden"][:1]
    assert hidden == ["hidden", 2.0, 2.036, "hidden: foot1"]
    assert not any("compensation" in p["title"] for p in page_data(render(dummy(foot=False)))["panels"])


def test_header_has_estimates_sources_and_flags_in_words():
    words = " ".join(parsed(render(dummy(flags="at-bound"))).words)
    for part in (
        "10.13",
        "(9.89 to 10.38)",
        "0.00012",
        "(0.00000 to 0.00030)",
        "N·m/rad",
        "250 Hz",
        "a.mat abababababab",
    ):
        assert part in words
    assert "leg, windowed least squares (K): a parameter lies at a bound of its search" in words
    assert "foot1 10." in words
    assert "recorded" in words


def row_of(html, words):
    """Words of the first table row that contains these words."""
    rows = re.findall(r"(?s)<tr>.*?</tr>", html)
    return re.sub(r"<[^>]+>", " ", next(row for row in rows if words in row))


def estimates_by(**ways):
    """Estimates of K by pathway: whether it is recommended, and its flags."""
    first = estimates_of()[0]
    rows = ((name.replace("_", "-"), *given) for name, given in ways.items())
    return [replace(first, pathway=name, recommended=told, flags=flags) for name, told, flags in rows]


def test_every_row_that_is_not_recommended_says_why():
    rows = estimates_by(
        leg=(True, "clipped"), leg_thesis=(False, ""), foot=(False, "clipped;at-bound"), other=(False, "")
    )
    table = header.estimates_table(rows, {})
    quoted, folded = table.split("<details>")[:2]
    assert "(recommended)" in quoted and "recommended because" not in quoted
    assert "method of the thesis, shown for comparison" in row_of(folded, "leg, thesis equation")
    # a check that the recommended estimate failed as well is no reason
    why = "the study recommends leg, windowed least squares"
    without = "the belt-induced load is not subtracted; a parameter lies at a bound of its search"
    assert without in row_of(folded, ">foot<")
    assert row_of(folded, ">other<").endswith(f"{why}  ")
    alone = header.estimates_table(estimates_by(leg=(False, "negative"), other=(False, "")), {})
    assert "No estimate of this trial is recommended" in alone and "(recommended)" not in alone
    assert "negative" in row_of(alone, ">leg<") and "does not quote it" in row_of(alone, ">other<")
    pooled = header.estimates_table(estimates_by(leg=(False, "")), {"instead": "the mean"})
    assert pooled.count("the study recommends the mean") == 2
    # a trial that was not asked for I, B, K or a mass has nothing to recommend
    (force,) = estimates_by(leg=(False, ""))
    assert "recommended" not in header.estimates_table([replace(force, quantity="added_force_peak")], {})


def test_caption_explains_marks_and_which_joint_a_true_value_belongs_to():
    rows = estimates_by(leg=(True, ""), other=(False, ""))
    keys = [("dummy", rows[0].condition, name, rows[0].estimator, "K") for name in ("leg", "other")]
    rows = [replace(row, experiment="dummy") for row in rows]
    truth = dict(zip(keys, (9.0, 10.0), strict=True))
    plain = header.estimates_table(rows, {"truth": truth})
    assert "so it differs between rows" in plain and "small movements" not in plain and "†" not in plain
    given = {"truth": truth, "small": keys[1:]}
    marked = header.estimates_table([rows[0], replace(rows[1], flags="clipped")], given)
    assert "For windowed least squares it is the constant for small movements. † marks estimates" in marked


def test_values_of_a_reflex_outside_its_search_are_told():
    (first,) = estimates_by(leg=(True, "reflex-outside-search"))
    ends = {"reflex_delay": 0.04, "reflex_delay_low": 0.0, "reflex_delay_high": 0.024}
    rows = [replace(first, quantity=name, value=value) for name, value in ends.items()]
    (said,) = header.flagged(rows, {})
    told = "of 0 to 24 ms, which are too short for a reflex, predict the torque at least as well as the 40 ms"
    assert f"reflex delays {told} used. Measure the reflex delay" in said
    (said,) = header.flagged([*rows[:2], replace(rows[2], value=0.0)], {})
    assert "a reflex delay of 0 ms, which is too short for a reflex, predicts the torque" in said
    (said,) = header.flagged([*rows[:2], replace(rows[2], value=0.09)], {})
    assert "reflex delays of 0 to 90 ms, outside the search, predict" in said
    # without its ends, or of a delay that is not flagged
    assert "reflex delays or thresholds outside" in header.flagged(rows[:1], {})[0]
    inside = [replace(rows[0], flags=""), *rows[1:]]
    assert "reflex delays or thresholds outside" in header.flagged(inside, {})[0]


def test_a_pathway_that_is_named_after_its_estimator_is_named_once():
    leg, other = estimates_by(leg_joint_likelihood=(True, ""), other=(False, ""))
    table = header.estimates_table([replace(leg, estimator="joint-likelihood"), other], {})
    assert "the study recommends leg, joint likelihood<" in table


def test_pages_of_other_recordings_do_not_name_the_thesis():
    rows = estimates_by(leg=(True, ""), leg_thesis=(False, "at-bound"))
    given = {"study": "s", "condition": "a", "belt": "right", "recommended": "leg", "made": False}
    size = treadmill_trial().time.size
    pages = [
        render(dummy_page(treadmill_trial(), leg_result(size), None, rows, given | {"neutral": neutral}))
        for neutral in (False, True)
    ]
    assert "thesis" in "".join(parsed(pages[0]).words) and "Torque, leg, thesis equation" in pages[0]
    assert "thesis" not in "".join(parsed(pages[1]).words) and "single-body equation" in pages[1]


def test_a_page_has_the_command_that_makes_its_trial_again():
    html = render(dummy(), again="snakemake -c1 dummy/<i>")
    assert "Repeat this trial: " in parsed(html).words and "snakemake -c1 dummy/<i>" in parsed(html).words
    assert "Repeat this trial: " not in parsed(render(dummy())).words


def test_trial_without_hidden_markers_says_so():
    trial = treadmill_trial()
    hidden = trial.signals["marker_hidden"]
    trial.signals["marker_hidden"] = replace(hidden, values=np.zeros_like(hidden.values))
    assert "no marker was hidden" in render(dummy(trial=trial))


def test_standing_person_shows_epochs_that_are_used_and_why_others_are_not():
    html = render(standing())
    data = page_data(html)
    bands = data["axes"]["time"]["windows"]
    assert [b[0] for b in bands] == ["epoch", "left-out"]
    assert "marker 'foot1' was hidden" in bands[1][3]
    # the page of the trial needs no name of the trial
    assert "<li>Perturbation at 8.00 s left out: marker &#x27;foot1&#x27; was hidden.</li>" in html
    titles = [panel["title"] for panel in data["panels"]]
    assert "Electromyogram SOL (soleus)" in titles and "Torque, EMG-driven" in titles
    assert {panel["axis"] for panel in data["panels"]} == {"time", "onset"}


def test_standing_trial_that_is_left_out_has_a_page_with_the_reason():
    trial = treadmill_trial()
    fit, epochs = standing_results(trial, ["standing/a: a step"])
    epochs.arrays["onsets_s"] = np.empty(0)
    for key in [key for key in epochs.arrays if key.startswith(("perturbed/", "envelope"))]:
        epochs.arrays[key] = epochs.arrays[key][:0]
    facts = fit.facts | {"responses": 0, "muscles": []}
    choices = {
        "study": "s",
        "condition": "a",
        "task": "relax",
        "belt": "left",
        "recommended": [],
        "made": False,
    }
    html = render(standing_page(trial, Result({}, {}, facts), epochs, [], choices))
    assert "<li>A step.</li>" in html and "2, 0 used" in html
    data = page_data(html)
    assert [b[0] for b in data["axes"]["time"]["windows"]] == ["left-out", "left-out"]
    assert {panel["axis"] for panel in data["panels"]} == {"time"}


def test_manipulators_and_belt_show_predictions_and_unused_ends():
    panels = {p["title"]: p for p in page_data(render(wristalyzer()))["panels"]}
    assert [b[0] for b in panels["Angle"]["bands"]] == ["cut", "cut"]
    assert "stopped before it converged" in render(wristalyzer())
    panels = {p["title"]: p for p in page_data(render(position_manipulator()))["panels"]}
    assert [t["label"] for t in panels["Torque"]["traces"]] == ["measured", "I, B, K", "parallel cascade"]
    assert panels["Torque"]["bands"][-1][0] == "held-out"
    panels = {p["title"]: p for p in page_data(render(belt()))["panels"]}
    assert [t["label"] for t in panels["Load, measured and predicted"]["traces"]] == [
        "measured",
        "hnat2014",
        "fir",
    ]


def test_weight_shows_force_predicted_by_the_models_of_a_trial_for_validation():
    titles = [p["title"] for p in page_data(render(weight()))["panels"]]
    assert "Belt-induced force, measured and predicted by the models" in titles
    titles = [p["title"] for p in page_data(render(weight(condition="sine-0.1")))["panels"]]
    assert "Belt-induced force, measured and predicted by the models" not in titles


@pytest.mark.parametrize(
    ("numbers", "shown"),
    [
        ((10.1272, 9.8917, 10.3791), ("10.13", "9.89 to 10.38")),
        ((-2.99, -3.031, -2.95), ("−2.990", "−3.031 to −2.950")),
        ((12345.6, 12000.0, 12700.0), ("12350", "12000 to 12700")),
        ((0.0002, -1e-9, 0.0004), ("0.00020", "0.00000 to 0.00040")),
        ((41.5, None, None), ("41.5", "")),
        ((float("nan"), 1.0, 2.0), ("–", "")),
        ((1.0, 1.0, 1.0), ("1.00", "")),
        ((1.0, 0.5, float("inf")), ("1.00", "0.500 to ∞")),
    ],
)
def test_estimates_have_the_digits_that_their_interval_allows(numbers, shown):
    assert by_uncertainty(*numbers) == shown


@pytest.mark.parametrize(
    ("shown", "value", "expected"),
    [("100.0", 99.998, "99.998"), ("100", 100.0, "100"), ("99.9", 99.94, "99.9"), ("−3", -3.0, "−3")],
)
def test_a_vaf_is_not_rounded_up_to_100(shown, value, expected):
    assert below_100(shown, value) == expected


def test_colours_of_bands_in_the_script_are_those_that_pages_use():
    from tepsipe.drawing.trial_page import BANDS

    fills = re.search(r"const FILLS = \{(.*?)\};", asset("plot.js"), re.DOTALL).group(1)
    assert set(re.findall(r'"([\w-]+)": "rgba', fills)) == set(BANDS)


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no Chromium: the page is not opened in a browser")
def test_page_draws_itself_in_a_browser_and_opens_at_the_part_in_its_address(tmp_path):
    page = dummy(study=NASTY)
    page = replace(page, windows=(*page.windows, Band("window", 10.0, 10.2, NASTY)))
    write_page(tmp_path / "page.html", page)
    address = f"{(tmp_path / 'page.html').as_uri()}#time=3.5,5.25"
    command = [
        BROWSER,
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    command += ["--enable-logging=stderr", "--virtual-time-budget=3000", "--dump-dom", address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert "CONSOLE" not in done.stderr
    root = re.search(r"<html[^>]*>", done.stdout).group()
    assert 'data-time="3.5000,5.2500"' in root
    assert f'data-panels="{len(page_data(render(page))["panels"])}"' in root
    assert done.stdout.count("<canvas") == len(page_data(render(page))["panels"])
    assert "3.500 to 5.250 s" in done.stdout
