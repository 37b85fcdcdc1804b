"""The model of the configuration: its documentation, its physical ranges, and who imports it."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import pytest
from annotated_types import Ge
from builders import assert_one_sentence
from pydantic import create_model

from tepsipe.arguments import check_options
from tepsipe.errors import InputError
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.quantities import (
    LIMITS,
    Band,
    Different,
    FilterOrder,
    Length,
    Mass,
    Meanings,
    Point,
    Rate,
    Thesis,
)
from workflow.settings.check import check_content, entries_of, section_of
from workflow.settings.config import Config, check_config
from workflow.settings.reported import Reported
from workflow.settings.section import Section, made_from, meaning_of
from workflow.settings.tables import README, _rows, updated
from workflow.settings.virtual_lab import VirtualLab
from workflow.support.imported_files import reached_by
from workflow.support.yaml_file import read_settings

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "workflow/scripts").glob("*.py"))


def test_tables_of_the_documentation_are_those_of_the_model():
    text = README.read_text(encoding="utf-8")
    assert updated(text) == text, "run `make format`"


def settings(section, where=""):
    for name, field in section.model_fields.items():
        inner = section_of(field.annotation) or section_of(entries_of(field.annotation))
        yield f"{where}{name}", section, inner
        if inner:
            yield from settings(inner, f"{where}{name}.")


@pytest.mark.parametrize("model", [Config, VirtualLab, Reported])
def test_every_setting_is_documented(model):
    undocumented = [
        key
        for key, section, inner in settings(model)
        if not inner and not meaning_of(section, key.rpartition(".")[2])
    ]
    assert not undocumented


# a number in another unit
OTHER_UNITS = [
    ("dummy.geometry.leg_com_m", 448.5, "at most 3", "m"),
    ("dummy.geometry.foot_height_m", 55, "at most 3", "m"),
    ("dummy.geometry.gravity_m_per_s2", 981.0, "at most 9.9", "m/s²"),
    ("weight.weight.gravity_m_per_s2", 0.00981, "at least 9.7", "m/s²"),
    ("weight.weight.mass_kg", 20000.0, "at most 500", "kg"),
    ("standing.person.stature_m", 175, "at most 2.6", "m"),
    ("standing.person.mass_kg", 64000.0, "at most 500", "kg"),
    ("standing.person.ankle_height_m", 8.0, "at most 0.3", "m"),
    ("standing.person.foot_com_m", 50.0, "at most 0.3", "m"),
    ("plate_treadmill.resample_rate_hz", 250000.0, "at most 100000", "Hz"),
    ("plate_treadmill.lowpass_cutoff_hz", 20000.0, "at most 5000", "Hz"),
    ("standing.analysis.after_s", 10000.0, "at most 3600", "s"),
    ("standing.free_reflex.reflex_onset_s", 45.0, "at most 1", "s"),
    ("noise.joint.stiffness_Nm_per_rad", [10.0, 15000000.0], "at most 20000", "N·m/rad"),
]


@pytest.mark.parametrize(("key", "value", "limit", "unit"), OTHER_UNITS, ids=[c[0] for c in OTHER_UNITS])
def test_number_in_another_unit_is_refused_with_its_unit(key, value, limit, unit, config):
    *sections, last = key.split(".")
    place = config
    for name in sections:
        place = place[name]
    place[last] = value
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert_one_sentence(caught.value, "my-study", key, f"a number of {limit} for", "found")
    assert str(caught.value).endswith(f": correct it; its unit is {unit}")


def test_marker_in_millimetres_is_refused(config):
    config["dummy"]["geometry"]["leg_markers"][1]["longitudinal_offset_m"] = 870.0
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert_one_sentence(caught.value, "my-study", "leg_markers.1.longitudinal_offset_m", "its unit is m")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("standing.person.stature_m", 175.0),
        ("dummy.subject.gravity_m_per_s2", 981.0),
        ("dummy.subject.leg_com_m", 448.5),
    ],
)
def test_laboratory_in_another_unit_is_refused(key, value, shipped_truth):
    truth = copy.deepcopy(shipped_truth)
    *sections, last = key.split(".")
    place = truth
    for name in sections:
        place = place[name]
    place[last] = value
    with pytest.raises(InputError) as caught:
        check_content(truth, VirtualLab, "lab.yaml")
    assert_one_sentence(caught.value, "lab.yaml", key)


ODD_VALUES = [
    ({"standing": {"participants": {1: {}}}}, ["standing.participants.1", "a text as key", "quotes"]),
    ({"position_manipulator": {"files": {"torque_sign": True}}}, ["one of 1, -1", "found True"]),
    (
        {"standing": {"pathways": {"Ankle": {"torque": "ankle", "treadmill_model": None}}}},
        ["of the pattern", "standing.pathways.Ankle"],
    ),
    ({"standing": {"muscles": {"TA": {"lengthened_by": {}}}}}, ["TA.lengthened_by", "at least 1 entry"]),
    ({"dummy": {"pathways": {}}}, ["at least 1 entry", "dummy.pathways"]),
    (
        {"belt": {"analysis": {"cutoffs_hz": [1.0, 2.0, 1.0]}}},
        ["belt.analysis.cutoffs_hz", "different items"],
    ),
    (
        {"plausible": {"force_N": [5.0, -5.0]}},
        ["plausible.force_N from low to high", "[5.0, -5.0]", "turn it"],
    ),
]


@pytest.mark.parametrize(("changes", "words"), ODD_VALUES, ids=[str(case[1][0]) for case in ODD_VALUES])
def test_odd_value_is_refused_in_the_words_of_the_study(changes, words, config):
    def override(section, changes):
        for key, value in changes.items():
            if isinstance(value, dict) and value and isinstance(section.get(key), dict):
                override(section[key], value)
            else:
                section[key] = value

    override(config, changes)
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert_one_sentence(caught.value, "my-study", *words)
    assert "pydantic" not in str(caught.value) and "Input should" not in str(caught.value)


def test_misspelt_key_is_reported_before_a_missing_one_and_values_that_do_not_fit(config):
    config["standing"]["recommended"]["pathway"] = "none"
    config["wristalyzer"]["analysis"]["fit_band_hz"] = [9.0, 1.0]
    config["belt"]["ingest"]["max_gap"] = config["belt"]["ingest"].pop("max_gap_s")
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert str(caught.value) == "my-study: unknown key 'belt.ingest.max_gap': did you mean 'max_gap_s'?"


def test_key_that_is_a_number_is_refused_as_unknown(config):
    config["study"][1] = "x"
    with pytest.raises(InputError) as caught:
        check_config(config, "my-study")
    assert str(caught.value).startswith("my-study: unknown key 'study.1': known here: name, title")


@pytest.mark.parametrize("name", ["plan", "walking", "coverage", "standing-platform"])
def test_shipped_studies_agree_with_the_model(name, config):
    def override(section, changes):
        for key, value in changes.items():
            if isinstance(value, dict) and isinstance(section.get(key), dict):
                override(section[key], value)
            else:
                section[key] = value

    override(config, read_settings(ROOT / f"config/{name}/config.yaml"))
    check_config(config, name)


def test_study_of_other_recordings_does_not_have_the_title_of_the_thesis(shipped_config, checked_study_of):
    check, title = checked_study_of("plan"), shipped_config["study"]["title"]

    def title_of(**changes):
        return check({f"study/{key}": value for key, value in changes.items()}).config["study"]["title"]

    assert title_of() == "Planning perturbations of the ankle dummy"
    assert title_of(title=title) == "Study of config/plan/trials.tsv"
    assert title_of(title=title, reported="config/reported.yaml") == title


PERTURBATIONS = [
    {"duration_s": 0.1},
    {"duration_s": 0.1, "force_N": 100.0},
    {"duration_s": 0.1, "displacement_m": 0.02, "segment": "thigh"},
]


@pytest.mark.parametrize("perturbation", PERTURBATIONS)
def test_perturbation_of_several_joints_is_a_movement_or_a_force(perturbation, checked_study_of):
    check = checked_study_of("plan")
    with pytest.raises(InputError) as caught:
        check({"plan/several_joints/perturbations/belt": perturbation})
    assert "plan.several_joints.perturbations.belt to have displacement_m" in str(caught.value)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_no_job_imports_the_model(script):
    for path in [*reached_by(str(script.relative_to(ROOT)), str(ROOT)), str(script.relative_to(ROOT))]:
        assert not path.startswith("workflow/settings/"), path
        assert "import pydantic" not in (text := (ROOT / path).read_text(encoding="utf-8")), path
        assert "from pydantic" not in text, path


# ---- ranges stand once -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Parts:
    """Parts of an example."""

    mass_kg: Mass
    """Mass of the part."""


@dataclass(frozen=True)
class Example:
    """An example."""

    length_m: Annotated[Length, Thesis("2-1")]
    """Butterworth length, which the
    thesis has."""
    order: FilterOrder
    """Order of both passes together."""
    count: Annotated[int, Ge(2), "pieces"]
    """*N*."""
    band_hz: Band
    """A band."""
    points_m: Different[Point]
    """Some points."""
    rate_hz: Rate | None
    """Rate; null if unknown."""
    parts: Mapping[str, Parts]
    """Name: a part."""
    torque: Annotated[Literal["leg", "foot"], Meanings({"leg": "of the leg", "foot": "of the foot"})]
    """Torque."""
    model: Annotated[str | None, Meanings({"null": "none"})] = None
    """Model."""


EXAMPLE = {
    "length_m": 1.0,
    "order": 4,
    "count": 2,
    "band_hz": [1.0, 2.0],
    "points_m": [[0.0, 1.0]],
    "rate_hz": None,
    "parts": {"a": {"mass_kg": 1.0}},
    "torque": "leg",
    "model": None,
}


def test_section_is_made_from_a_dataclass():
    section = made_from(Example)
    check_content(EXAMPLE, section, "here")
    rows = {row["Key"]: row for row in _rows(section, EXAMPLE) if "Key" in row}
    assert rows["`length_m`"]["Meaning"] == "Butterworth length, which the thesis has"
    assert rows["`length_m`"]["Thesis"] == "2-1" and rows["`length_m`"]["Unit"] == "m"
    assert rows["`count`"]["Unit"] == "pieces" and rows["`count`"]["Meaning"] == "*N*"
    assert rows["`parts.*.mass_kg`"]["Allowed"] == "above 0, at most 500"
    assert rows["`points_m`"]["Allowed"] == "list of lists of 2 numbers, −3 to 3"
    assert made_from(Example) is section
    assert list(made_from(Example, without=("model",)).model_fields) == list(EXAMPLE)[:-1]


def made_sections():
    """Every section of the model that is made from a dataclass, or has one that is as base."""
    models = (Config, VirtualLab, Reported)
    found = dict.fromkeys(inner for model in models for _, _, inner in settings(model) if inner)
    return [section for section in found if section.options is not None]


def test_no_section_restates_a_field_of_the_dataclass_that_it_is_made_from():
    made = made_sections()
    assert len(made) > 40
    for section in made:
        inherited = set(next(one for one in section.__mro__ if "options" in vars(one)).model_fields)
        if "options" not in vars(section):
            # another section, with validators or further keys, restates nothing
            own = {
                name
                for name in vars(section).get("__annotations__", {})
                if meaning_of(section, name) or not section_of(section.model_fields[name].annotation)
            }
            assert not own & inherited, f"{section.__name__} restates {own & inherited}"


def test_every_limit_of_the_configuration_is_that_of_the_library():
    """A number just beyond is refused by both in the same words."""
    seen = set()
    for section in made_sections():
        for name, field in section.model_fields.items():
            limits = [(kind, getattr(m, kind)) for m in field.metadata for kind in LIMITS if hasattr(m, kind)]
            for kind, limit in limits:
                if name not in section.options.__dataclass_fields__ or kind.endswith("_length"):
                    continue
                beyond = limit + {"gt": 0, "ge": -2, "lt": 0, "le": 2, "multiple_of": 1}[kind]
                with pytest.raises(InputError) as library:
                    check_options(section.options, {name: beyond}, "here")
                only = create_model("Only", __base__=Section, **{name: (field.annotation, field)})
                with pytest.raises(InputError) as configuration:
                    check_content({name: beyond}, only, "here")
                assert str(library.value) == str(configuration.value)
                seen.add((section.options, name, kind))
    assert len(seen) > 150


def test_functions_refuse_what_the_configuration_refuses(config):
    legs = {"com_m": 448.5, "mass_kg": -0.4}
    for name, value in legs.items():
        with pytest.raises(InputError) as caught:
            Leg(**{"com_m": 0.4, "mass_kg": 0.4, "inertia_kgm2": 0.01} | {name: value})
        config["dummy"]["geometry"][f"leg_{name}"] = value
        with pytest.raises(InputError) as refused:
            check_config(config, "my-study")
        limit = {"com_m": "3", "mass_kg": "0"}[name]
        assert limit in str(caught.value) and limit in str(refused.value)
        config["dummy"]["geometry"][f"leg_{name}"] = 0.4


REFUSED = [
    ("length_m", 448.5),
    ("length_m", "1"),
    ("order", 3),
    ("order", True),
    ("count", 1),
    ("count", 2.5),
    ("band_hz", [2.0, 1.0]),
    ("band_hz", [1.0]),
    ("band_hz", 1.0),
    ("points_m", []),
    ("points_m", [[0.0, 1.0], [0.0, 1.0]]),
    ("points_m", [[0.0, 4.0]]),
    ("rate_hz", 0.0),
    ("parts", {"a": {"mass_kg": 501.0}}),
    ("parts", [1]),
    ("torque", "hip"),
    ("model", 1),
]


@pytest.mark.parametrize(("key", "value"), REFUSED, ids=[f"{key}-{value}" for key, value in REFUSED])
def test_library_refuses_what_the_configuration_refuses(key, value):
    messages = []
    for check in (
        lambda content: check_content(content, made_from(Example), "here"),
        lambda content: check_options(Example, content, "here"),
    ):
        check(EXAMPLE)
        with pytest.raises(InputError) as caught:
            check(EXAMPLE | {key: value})
        assert_one_sentence(caught.value, "here", key)
        messages.append(str(caught.value))
    if isinstance(value, float | int):
        assert messages[0] == messages[1]
