"""The report as a page for a browser, from the same sources, numbers and tables as the PDF."""

import job

job.start(snakemake)

import json
import os
import re
from pathlib import Path

import yaml
from typeset import report_files, source_files, table_files, typeset_page

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.recovery_table import RECOVERIES
from tepsipe.reporting.pages.explorers import apparent, specification
from tepsipe.reporting.pages.html import table
from tepsipe.reporting.pages.markdown import html_of, inline
from tepsipe.reporting.pages.report_page import Origin, ReportPage, link, render_report
from tepsipe.reporting.pages.trials import trial_rows, trials_table
from workflow.support.origins import Chapter, Sources, command

given, params = snakemake.input, snakemake.params
tables = table_files(given.tables)
sources = Sources(params.root, params.kind)


def beside(path):
    """A file as seen from the folder of the page."""
    return Path(os.path.relpath(path, Path(snakemake.output.html).parent)).as_posix()


def again(target, rules):
    """Command that makes a file of the study again."""
    return command(target, rules, params.configfiles)


def size_of(path):
    """Width and height of a picture (points)."""
    found = re.search(
        r'width="([\d.]+)pt" height="([\d.]+)pt"', Path(path).read_text(encoding="utf-8")[:2000]
    )
    return (float(found[1]), float(found[2])) if found else (0.0, 0.0)


def origin_of_figure(path, numbers):
    """Files, code and command of a figure (SVG)."""
    name = Path(path).stem
    rule = sources.rule_of_figure(name)
    data = {f"{name}.{kind}": beside(Path(path).with_suffix(f".{kind}")) for kind in ("csv", "svg", "png")}
    if Path(numbers).read_text(encoding="utf-8").count("\n") < 2:
        del data[f"{name}.csv"]  # a drawing without numbers, which rests on the settings
        data["config.yaml"] = "../config.yaml"
    return Origin(data, sources.code_of_figure(name, rule), again(path, [rule.name]))


def origin_of_tables(chapter, label=None):
    """Files, code and command of a table of the report, or of all tables of a chapter."""
    names, line = chapter.tables_read(label)
    names = names or chapter.tables_read()[0]
    read = {name: tables[name] for name in names if name in tables}
    rules = {name: rule for name in read if (rule := sources.rule_of_table(name))}
    code = [("Typeset by", f"report/{chapter.name}:{line}")]
    for rule in dict.fromkeys(rules.values()):
        code += sources.code_of_table(rule)
    data = {f"{name}.csv": beside(path) for name, path in read.items()}
    targets, forced = [read[name] for name in rules], [rule.name for rule in dict.fromkeys(rules.values())]
    if "report" in names or not data:
        data[Path(given.data).name] = beside(given.data)
        code.append(("Numbers", f"tepsipe/reporting/chapters/ ({params.written_by})"))
        targets, forced = [*targets, given.data], [*forced, params.written_by]
    return Origin(data, code, again(" ".join(targets), forced))


chapters = [
    Chapter(Path(params.root) / "report", name)
    for name in source_files(given.source, params.source_folder)
    if name.startswith("chapters/") or name in (params.main, "several_joints.typ")
]
origins = {
    Path(path).stem: origin_of_figure(path, numbers)
    for path, numbers in zip(given.figures, given.numbers, strict=True)
}
for chapter in chapters:
    origins[chapter.name] = origin_of_tables(chapter)
    origins |= {label: origin_of_tables(chapter, label) for label in chapter.labels if label not in origins}

decisions = {}
for path in given.decisions:
    title, _, words = Path(path).read_text(encoding="utf-8").partition("\n")
    decisions[int(Path(path).name[:4])] = (
        title.lstrip("# ").partition(". ")[2],
        html_of(words),
        Path(path).name,
    )

# tables of the run, also those that the report does not read
run_tables = {name: f"{params.results}/tables/{name}.csv" for name in params.captions} or tables
citation = yaml.safe_load(Path(given.citation).read_text(encoding="utf-8"))
authors = ", ".join(
    person.get("name") or f"{person.get('given-names', '')} {person.get('family-names', '')}".strip()
    for person in citation["authors"]
)
code = params.code
commit = (code["commit"] or "")[:12] + (", with uncommitted changes" if code["modified"] else "")
parts = {}
if params.trials:
    estimates = ESTIMATES.read(tables["estimates"])
    truth = RECOVERIES.read(tables["recovery"]) if "recovery" in tables else []
    parts["trials"] = ("Trials", trials_table(trial_rows(params.trials, estimates, truth)))
parts["tables-of-the-run"] = (
    "Tables of the run",
    table(
        ("Table", "Content"),
        [
            [link(beside(path), f"{name}.csv"), inline(params.captions.get(name, "").replace("``", "`"))]
            for name, path in run_tables.items()
        ],
    ),
)
explored = {}
if "dummy" in params.trials and "recovery" in tables:
    settings = json.loads(Path(given.data).read_text(encoding="utf-8"))["choices"]["dummy"]
    explored["figure_torque"] = ("apparent", apparent(settings["geometry"], truth))
    explored["figure_specification"] = ("specification", specification(tables["specification"], truth))
page = ReportPage(
    title=params.title,
    facts=[
        ("Authors of the software", authors),
        ("Version", citation["version"]),
        ("Commit", commit),
        ("Date of the commit", code["date"]),
    ],
    files={words: beside(path) for words, path in params.forms.items()},
    sizes={f"../figures/{Path(path).name}": size_of(path) for path in given.figures},
    source=params.main,
    origins=origins,
    rests_on=yaml.safe_load(Path(given.rests_on).read_text(encoding="utf-8")),
    decisions=decisions,
    parts=parts,
    explored={figure: content for figure, content in explored.items() if content[1]},
)
files = source_files(given.source, params.source_folder)
files |= report_files(given.data, tables, given.figures)
html = render_report(typeset_page(files, params.main), page)
Path(snakemake.output.html).write_text(html, encoding="utf-8", newline="\n")
