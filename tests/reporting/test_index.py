"""The index of a run, and the sentences that it shares with the PDF."""

import json
import unicodedata
from urllib.parse import unquote

from joint_builders import content_of, fit_of, rows_of, run_of
from page_builders import NASTY, parsed
from typst_builders import first_page_of, plain_words

from tepsipe.reporting.numbers.abstract import abstract_of, pieces, warnings_of
from tepsipe.reporting.numbers.study import provenance_data
from tepsipe.reporting.pages.index import Listing, render_index

CLAIMS = {
    "total": "2",
    "reproduced": "1",
    "explained": "1",
    "not_reproduced": "0",
    "fitted": "0",
    "predicted": "0",
    "not_computed": "0",
    "rows": [
        {
            "claim": "K <",
            "unit": "N·m/rad",
            "where": "p. 3",
            "reported": "10",
            "reproduced": "9",
            "verdict": "v",
        }
    ],
}
RECORDED = {
    "title": "A study",
    "made": 0,
    "trials": 2,
    "recordings_source": None,
    "experiments": ["position_manipulator"],
    "reported": None,
    "claims": None,
    "cells": None,
    "provenance": provenance_data(
        {
            "commit": "abc",
            "modified": False,
            "python": "3.13.0",
            "engine": None,
            "config_sha256": "f00",
            "seed": 1,
            "packages": {"numpy": "2.0"},
            "files": {"sheet": {"file": "a.tsv", "sha256": "ab"}},
            "raw_files": {},
        }
    ),
    "flags": {"count": 0, "total": 10, "kinds": [], "recommended": {"count": "0", "total": "4", "kinds": []}},
}


def report(**changed):
    data = RECORDED | changed
    told = {"summary": [], "warnings": warnings_of(data), "abstract": abstract_of(data)}
    return data | told | {"first_page": first_page_of(data | told, "./my%20study.pdf")}


def listing(condition="trial1"):
    return Listing(
        pdf="my study.pdf",
        figures={"Category": {"figure_4_4": "Boxes of I, B & K."}},
        tables={"estimates": "All <estimates> of ``a<b.csv``."},
        trials={"position_manipulator": [condition, "trial2"], "standing": ["relax"]},
        activity=["relax"],
    )


def plain(paragraphs):
    return "".join(words for paragraph in paragraphs for _, words in paragraph)


def source(**changed):
    return " ".join(parsed(report(**changed)["first_page"]["source"]).words)


def test_markup_of_a_template_is_not_sought_in_its_values():
    found = pieces('_{task}_ has $2 I_"leg"$ = {a_b_c} *{x}* [@claims]', task="_$x$_", a_b_c="*1*", x="{y}")
    assert found == [
        ["emph", "_$x$_"],
        ["text", " has "],
        ["math", '2 I_"leg"'],
        ["text", " = *1* "],
        ["strong", "{y}"],
        ["text", " "],
        ["ref", "claims"],
    ]


def test_source_tells_simulated_trials_from_recordings():
    assert "The 2 trials in this report are recordings listed" in source()
    assert "The trial in this report is a recording listed" in source(trials=1)
    assert source(recordings_source="REKLAB, _GPL_").endswith("Source: REKLAB, _GPL_")
    assert "Of the 2 trials in this report, 1 were simulated" in source(made=1)
    assert "All 2 trials in this report were simulated" in source(made=2)


def test_abstract_has_what_the_study_has():
    assert abstract_of(RECORDED) == {}
    (claims,) = abstract_of(RECORDED | {"claims": CLAIMS}).values()
    assert "Of the 2 claims of the thesis, 1 are reproduced" in plain(claims)
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    told = {"summary": [], "warnings": [], "abstract": {"claims": claims}}
    page = first_page_of(content | told, "./a.pdf", tables)["findings"]
    assert page.count("<p>") == 4
    words = plain_words(page).replace("\u2060", "")
    assert "stiffness of the joint is K = 50.0 N·m/rad" in words and "Of the 2 claims" in words
    assert "Wristalyzer" not in words and "platform" not in words


def test_formulas_sections_and_references_of_the_first_page_are_html():
    told = pieces('As _x_ says <b> $2 I_"leg"$ = 10 N·m/rad ([@claims]).')
    content = {"made": 1, "trials": 1, "summary": [told], "warnings": [], "abstract": {}}
    page = first_page_of(content, "./a%20b.pdf")
    assert "of the thesis were never published" in page["source"]
    assert unicodedata.normalize("NFKC", page["findings"]).replace("\u2060", "") == (
        "<p>As <em>x</em> says &lt;b> <math><mn>2</mn><msub><mi>I</mi><mtext>leg</mtext></msub></math> = 10 "
        'N·m/rad (<a href="./a%20b.pdf">the report</a>).</p>'
    )
    # a value stays on the line of its sign and of its unit
    assert "</math>\xa0=\xa010\xa0N" in page["findings"]


def test_index_links_every_file_relatively_and_needs_no_script():
    html = render_index(report(claims=CLAIMS), listing())
    reader = parsed(html)
    assert reader.scripts == []
    files = {unquote(link).removeprefix("./") for link in reader.links if not link.startswith("#")}
    assert files == {
        "my study.pdf",
        "report.html",
        "trials/position_manipulator/trial1.html",
        "trials/position_manipulator/trial2.html",
        "trials/standing/relax.html",
        "../figures/standing/relax_4_13.png",
        "../figures/standing/relax_4_14.png",
        "../figures/figure_4_4.svg",
        "../figures/figure_4_4.png",
        "../tables/estimates.csv",
        "../provenance.json",
        "../config.yaml",
    }
    assert {link[1:] for link in reader.links if link.startswith("#")} < set(reader.ids)
    assert "All &lt;estimates&gt; of <code>a&lt;b.csv</code>." in html
    assert "Boxes of I, B & K." in " ".join(reader.words)
    for outside in ("http:", "https:", 'href="/', "url("):
        assert outside not in html


def test_index_names_flagged_estimates():
    flags = {"count": 3, "total": 9, "kinds": [{"name": "at-bound", "count": "3", "meaning": "look <at> it"}]}
    flags |= {"recommended": {"count": "2", "total": "4", "kinds": []}}
    words = " ".join(parsed(render_index(report(flags=flags), listing())).words)
    assert "3 of 9" in words and "look <at> it" in words and "Look at these first" not in words
    kinds = [{"name": "at-bound", "where": "K, B of dummy sine_0.1", "meaning": "the <bound> is met"}]
    flags["recommended"]["kinds"] = kinds
    words = " ".join(parsed(render_index(report(flags=flags), listing())).words)
    assert "2 of the 4 recommended estimates failed a check" in words
    assert "K, B of dummy sine_0.1" in words and "the <bound> is met." in words
    assert "Flagged" not in render_index(report(), listing())


def test_no_name_of_a_user_breaks_the_index():
    html = render_index(report(title=NASTY, recordings_source=NASTY), listing(condition="a:b #1?%<i>"))
    reader = parsed(html)
    assert reader.scripts == [] and "<b> " not in html
    assert NASTY in "".join(reader.words)
    assert "./trials/position_manipulator/a%3Ab%20%231%3F%25%3Ci%3E.html" in reader.links


def test_same_content_gives_the_same_index():
    assert json.dumps(report()) == json.dumps(report())
    assert render_index(report(), listing()) == render_index(report(), listing())
