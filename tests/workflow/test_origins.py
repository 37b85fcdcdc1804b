"""Origins of figures and tables: found in the sources, for all that a report can show."""

import ast
import re
from pathlib import Path

import pytest

from tepsipe.reporting.report_page import Origin
from workflow.support import outputs
from workflow.support.captions import read_captions
from workflow.support.origins import Chapter, ReportOrigins, Sources, chapters_of, command, repository_at
from workflow.support.study import Study
from workflow.support.trial_sheet import read_trial_sheet

ROOT = Path(__file__).parents[2]
FIGURES = [name for name in read_captions(ROOT / "report/captions.yaml") if name.startswith("figure_")]
OWN = {
    "coverage": ("figure_coverage", "figure_coverage_intervals"),
    "plan": ("figure_needed", "figure_filters", "figure_several_joints"),
    "walking": ("figure_walking",),
}


def has_line(place, words):
    path, line = place.rsplit(":", 1)
    return words in (ROOT / path).read_text(encoding="utf-8").splitlines()[int(line) - 1]


@pytest.mark.parametrize(
    ("kind", "figure"),
    [(None, name) for name in FIGURES] + [(kind, name) for kind, names in OWN.items() for name in names],
)
def test_every_figure_has_its_rule_and_the_function_that_draws_it(kind, figure):
    sources = Sources(ROOT, kind)
    rule = sources.rule_of_figure(figure)
    # rules that a loop over experiments makes have no name of their own there
    looped = rule.place.startswith("workflow/rules/experiments.smk:")
    assert has_line(rule.place, "    rule:" if looped else f"rule {rule.name}")
    function, place = re.fullmatch(
        r"(\w+) \((.*)\)", dict(sources.code_of_figure(figure, rule))["Function"]
    ).groups()
    word = "#let" if place.startswith("report/drawings.typ:") else "def"
    assert word == "#let" or re.match(r"tepsipe/(\w+/)+figures\.py:|tepsipe/drawing/", place)
    assert has_line(place, f"{word} {function}(")


def test_the_source_of_every_function_is_found_at_its_line():
    sources = Sources(ROOT)
    code = [part for name in FIGURES for part in sources.code_of_figure(name, sources.rule_of_figure(name))]
    functions = sources.functions([Origin({}, code, "")])
    assert set(functions) == {place for what, place in code if what == "Function"}
    for place, source in functions.items():
        name = place.partition(" ")[0]
        assert re.match(rf"(def|#let) {name}\(", source), place
        if source.startswith("def"):
            assert ast.parse(source).body[0].name == name
        else:
            first, *_, last = source.splitlines()
            assert first[-1] in "{([" and last[0] in "})]", place


def test_sources_are_linked_if_the_project_names_an_address(tmp_path):
    def at(project, commit="0123"):
        (tmp_path / "pyproject.toml").write_text(f"[project]\n{project}\n")
        return repository_at(tmp_path, commit)

    address = '[project.urls]\nRepository = "https://a.example/b"'
    assert at(address) == "https://a.example/b/blob/0123"
    assert at(address, None) == at("") == ""
    assert repository_at(tmp_path / "absent", "0123") == ""


@pytest.mark.parametrize(
    "table", ["estimates", "table_4_2", "table_4_4", "recovery", "cells", "forward", "planned"]
)
def test_every_table_has_its_rule_and_script(table):
    sources = Sources(ROOT)
    rule = sources.rule_of_table(table)
    assert has_line(rule.place, f"rule {rule.name}") and (ROOT / rule.script).is_file()
    for what, place in sources.code_of_table(rule)[2:]:
        name, line = re.fullmatch(r"(\w+) \((.*)\)", place).groups()
        assert what == "Function" and has_line(line, f"def {name}(")


def test_rows_of_estimates_come_from_the_rules_that_made_them(config):
    study = Study(config, read_trial_sheet(ROOT / config["study"]["trial_sheet"], "."))
    joined = outputs.joined(study)
    sources = Sources(ROOT)
    for table, rows in joined.items():
        for experiment, files in rows.items():
            rules = {sources.rule_of_rows(file).name for file in files}
            assert rules, (table, experiment)
    fitted = {sources.rule_of_rows(file).name for file in joined["estimates"]["standing"]}
    assert fitted == {"fit_standing", "fit_standing_task", "compare_standing_tasks"}
    code = sources.code_of_rows(joined["estimates"]["standing"])
    (place,) = [place for what, place in code if what == "Function" and "standing/fit.py" in place]
    assert has_line(re.fullmatch(r"fit \((.*)\)", place)[1], "def fit(")


OF_TABLES = ("standing", "standing_further", "dummy", "dummy_further")


def test_tables_of_the_standing_person_name_no_function_of_the_dummy(config):
    study = Study(config, read_trial_sheet(ROOT / config["study"]["trial_sheet"], "."))
    tables = {name: f"results/tables/{name}.csv" for name in outputs.tables(study)}
    joined = outputs.joined(study)
    made = ReportOrigins(
        Sources(ROOT), "results/report/index.html", tables, "report.json", "write_report", (), joined
    )
    chapters = chapters_of(ROOT / "report", [f"chapters/{own}.typ" for own in OF_TABLES], "report.typ")
    found = made.of_report({}, chapters, {})
    for label in ("standing-estimators", "standing-trials", "standing-truth", "standing-pathways-table"):
        code = " ".join(place for _, place in found[label].code)
        made_by = "compare_with_truth" if label == "standing-truth" else "fit_standing"
        assert made_by in code and "collect_" in code, label
        assert "dummy" not in code and "wristalyzer" not in code, label
    # the table of true and estimated parameters of the dummy names its own rules
    code = " ".join(place for _, place in found["dummy-table"].code)
    assert "compare_with_truth" in code and "fit_standing" not in code


def test_a_table_names_what_it_reads_through_other_sources_and_not_more():
    recovery, reproduction = (
        Chapter(ROOT / "report", f"chapters/{name}.typ") for name in ("recovery", "reproduction")
    )
    assert recovery.tables_read("recovery-table")[0] == ["recovery"]
    assert "claims" in reproduction.tables_read("reproduced")[0]
    names, line = Chapter(ROOT / "report", "chapters/laboratory.typ").tables_read("mechanisms")
    assert names == ["laboratory"] and has_line(f"report/chapters/laboratory.typ:{line}", "figure(")
    assert set(reproduction.tables_read()[0]) >= {"claims", "cells"}


def test_a_bracket_in_a_string_does_not_lengthen_a_definition(tmp_path):
    (tmp_path / "own.typ").write_text(
        '#let plain(row) = row.replace("sqrt(", "(")\n'
        '#let further = rows-of("dropped")\n'
        '#figure(plain(rows-of("cells"))) <one>\n'
    )
    assert Chapter(tmp_path, "own.typ").tables_read("one") == (["cells"], 3)


def test_command_makes_a_file_by_its_rules_with_the_configuration_of_the_run():
    assert command("a.svg", ["plot_dummy"], []) == "snakemake -c1 a.svg --forcerun plot_dummy"
    assert command("a.csv", ["x", "y"], ["own.yaml"]).endswith("--forcerun x y --configfile own.yaml")


def test_a_table_that_is_kept_with_the_project_is_named_but_not_linked(tmp_path):
    (tmp_path / "chapters").mkdir()
    (tmp_path / "chapters/a.typ").write_text('#figure(table(..rows-of("coverage"))) <a>\n#rows-of("claims")')
    tables = {"coverage": ROOT / "benchmarks/coverage/coverage.csv", "claims": "results/tables/claims.csv"}
    made = ReportOrigins(
        Sources(ROOT), "results/report/index.html", tables, "results/report/report.json", "x"
    )
    found = made.of_report({}, [Chapter(tmp_path, "chapters/a.typ")], {})
    assert list(found["a"].data) == ["report.json"] and list(found["chapters/a.typ"].data) == ["claims.csv"]
    for name in ("a", "chapters/a.typ"):
        assert ("Kept data", "benchmarks/coverage/coverage.csv") in found[name].code


def test_a_part_of_the_page_names_its_function_and_tables():
    tables = {name: f"results/tables/{name}.csv" for name in ("estimates", "claims")}
    made = ReportOrigins(Sources(ROOT), "results/report/index.html", tables, "report.json", "write_report")
    part = made.of_report({}, [], {"trials": ("trials_table", ("estimates", "recovery"))})["trials"]
    functions = [place for what, place in part.code if what == "Function"]
    assert [place.partition(" ")[0] for place in functions] == ["trials_table"]
    assert dict(part.data) == {"estimates.csv": "../tables/estimates.csv"}
    assert part.command.endswith("--forcerun write_index")
