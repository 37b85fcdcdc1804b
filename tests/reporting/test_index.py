"""The index of a run, and the sentences that it shares with the PDF."""

import unicodedata
from urllib.parse import unquote

from joint_builders import content_of, fit_of, rows_of, run_of
from page_builders import NASTY, parsed
from study_chapter_builders import CLAIM, estimate, study_content, study_run
from typst_builders import index_parts_of, plain_words

from tepsipe.reporting.pages.index import Listing, render_index


def parts(claims=(), cells=(), estimates=(), **study):
    """Parts of the index of a study with two trials of the manipulator."""
    tables = {"estimates": [estimate(), *estimates]}
    tables |= {"claims": claims} if claims else {}
    tables |= {"cells": cells} if cells else {}
    return index_parts_of(*study_content(study_run(tables, **study)))


def page(condition="trial1", title="A study", **changed):
    listing = Listing(
        pdf="my study.pdf",
        figures={"Category": {"figure_4_4": "Boxes of I, B & K."}},
        tables={"estimates": "All <estimates> of ``a<b.csv``."},
        trials={"position_manipulator": [condition, "trial2"], "standing": ["relax"]},
        activity=["relax"],
    )
    return render_index(title, parts(**changed), listing)


def source(**changed):
    return plain_words(parts(**changed)["source"])


def test_source_tells_simulated_trials_from_recordings():
    one = {"position_manipulator": ["a"]}
    assert "The 2 trials in this report are recordings listed" in source()
    assert "The trial in this report is a recording listed" in source(experiments=one)
    assert source(recordings_source="REKLAB, _GPL_").endswith("Source: REKLAB, _GPL_")
    assert "Of the 2 trials in this report, 1 were simulated" in source(made=one)
    both = {"position_manipulator": ["a", "b"]}
    assert "All 2 trials in this report were simulated" in source(made=both)


def test_abstract_has_what_the_study_has():
    assert parts()["findings"] == ""
    findings = plain_words(parts(claims=[CLAIM, CLAIM | {"verdict": "explained"}])["findings"])
    assert findings.startswith("Verdicts on the 2 claims of the thesis: 1 pattern, 1 explained.")
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    study, claims = study_content(study_run({"claims": [CLAIM, CLAIM]}))
    content["chapters"] |= study["chapters"]
    findings = index_parts_of(content, tables | {"claims": claims["claims"]})["findings"]
    assert findings.count("<p>") == 4
    words = plain_words(findings).replace("\u2060", "")
    assert "stiffness of the joint is K = 50.0 N·m/rad" in words and "Verdicts on the 2 claims" in words
    assert "Wristalyzer" not in words and "platform" not in words


def test_formulas_sections_and_references_of_the_first_page_are_html():
    findings = parts(claims=[CLAIM])["findings"]
    assert '(<a href="./my%20study.pdf">the report</a>).</p>' in findings
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    content["chapters"] |= study_content(study_run({}))[0]["chapters"]
    html = unicodedata.normalize("NFKC", index_parts_of(content, tables)["findings"]).replace("\u2060", "")
    assert "<math><mi>K</mi></math> = 50.0 N·m/rad" in html
    # a value stays on the line of its sign and of its unit
    assert "=\xa050.0\xa0N" in index_parts_of(content, tables)["findings"].replace("\u2060", "")
    assert "of the thesis were never published" in source(made={"position_manipulator": ["a"]})


def test_index_links_every_file_relatively_and_needs_no_script():
    html = page(claims=[CLAIM])
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


def test_index_lists_claims_cells_and_provenance():
    cell = {"table": "table_4_2", "row": "VAF_trial", "column": "sine-0.3", "reported": 99.9, "value": 91.137}
    cell |= {"tolerance": 1, "verdict": "not reproduced", "reason": "it <rests>; used: a joint"}
    cell |= {"null_value": 99.8, "null_verdict": "implied"}
    cells, ran = [cell, cell | {"verdict": "fitted"}], [estimate(condition="sine-0.3")]
    html = page(claims=[CLAIM], cells=cells, estimates=ran)
    words = plain_words(html.replace("</t", " | </t"))
    assert "K < (N·m/rad) | p. 3 | < 10 | 9 | pattern | 10 | a joint |" in words
    assert "4-2 | 0 | 1 | 0 | 0 | 0 | 0 | 1 | 0 | 0 | 1 | 2 |" in words
    # the null model is nearer, row by row
    assert "4-2, VAF of the full dataset | 2 | 1 | 2 | 8.8 | 0.10 |" in words
    assert "4-2 | VAF of the full dataset: S3 (99.9, 91.14) | it <rests> |" in words
    assert "Every printed cell" not in page(claims=[CLAIM]) and "All claims" not in page(cells=[cell])
    assert "<dt>Commit</dt><dd>abc</dd>" in html and "numpy 2.0" in words
    assert '<th scope="row">sheet</th><td><code>a.tsv</code></td>' in html


def test_index_names_flagged_estimates():
    flagged = [estimate(condition=c, flags="at-bound") for c in "ab"]
    words = plain_words(page(estimates=flagged))
    assert "2 of 3 estimates failed a check" in words and "at-bound (2): a parameter lies at a bound" in words
    assert "Look at these first" not in words
    words = plain_words(page(estimates=[e | {"recommended": True} for e in flagged]))
    assert "2 of the 2 recommended estimates failed a check" in words
    assert "K of the position-controlled manipulator (a, b): a parameter lies" in words
    assert "Flagged" not in page()


def test_no_name_of_a_user_breaks_the_index():
    html = page(title=NASTY, recordings_source=NASTY, condition="a:b #1?%<i>")
    reader = parsed(html)
    assert reader.scripts == [] and "<b> " not in html
    assert NASTY in "".join(reader.words)
    assert "./trials/position_manipulator/a%3Ab%20%231%3F%25%3Ci%3E.html" in reader.links


def test_same_content_gives_the_same_index():
    assert page(claims=[CLAIM]) == page(claims=[CLAIM])
