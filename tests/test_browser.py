"""Pages of a tiny study in a real browser, from files: no errors, readable on a telephone."""

import browser_driver
import pytest

from tepsipe.drawing.names import PARAMETER_SETS
from tepsipe.experiments.forward.scores import FORWARD_SCORES

pytestmark = [
    pytest.mark.study,
    pytest.mark.browser,
    pytest.mark.skipif(
        not (browser_driver.CHROMIUM and browser_driver.CHROMEDRIVER), reason=browser_driver.MISSING
    ),
]


@pytest.fixture(scope="module")
def browser():
    with browser_driver.browser() as opened:
        yield opened


@pytest.fixture
def report(study, browser):
    """The browser with the report. Every test uses another part of the page."""
    browser.show(study / "results/report/index.html")
    return browser


@pytest.mark.parametrize("width", [390, 1280])
def test_report_opens_without_errors_and_fits_into_the_window(study, browser, width):
    browser.show(study / "results/report/index.html", width)
    for theme in ("light", "dark"):
        browser.run("document.documentElement.dataset.theme = given[0]", theme)
        # all images are loaded, and nothing but wide tables and formulas is wider than the window
        broken = """
            document.querySelectorAll("img").forEach((image) => { image.loading = "eager"; });
            await Promise.all([...document.images].map((image) => image.decode().catch(() => null)));
            return [...document.images].filter((image) => !image.naturalWidth).map((image) => image.src);
        """
        assert browser.run(broken) == []
        assert browser.run("return document.documentElement.scrollWidth - innerWidth") <= 0
        assert browser.log() == []
    assert browser.run("return performance.getEntriesByName('first-contentful-paint')[0].startTime") < 3000


def test_search_finds_words_and_shows_their_place(report):
    typed = """
        const field = document.getElementById("search");
        field.value = given[0];
        field.dispatchEvent(new Event("input"));
        return [...document.querySelectorAll("#found li")].map((item) => item.textContent);
    """
    found = report.run(typed, "bystander")
    assert found == ["Nothing found."]
    found = report.run(typed, "virtual laboratory")
    assert len(found) > 3 and "virtual laboratory" in found[1].lower()


def test_trials_are_sorted_and_filtered(report):
    shown = (
        "return [...document.querySelectorAll('#trials-table tbody tr:not([hidden])')].map((row) => row.{})"
    )
    experiments = report.run(shown.format("dataset.experiment"))
    assert len(experiments) == 10
    of = "const e = document.getElementById('trials-of'); e.value = 'dummy';"
    of += "e.dispatchEvent(new Event('input'));"
    assert set(report.run(of + shown.format("dataset.experiment"))) == {"dummy"}
    press = "document.querySelectorAll('#trials-table thead button')[3].click();"
    rising = report.run(press + shown.format("cells[3].dataset.value"))
    falling = report.run(press + shown.format("cells[3].dataset.value"))
    assert rising == sorted(rising, key=float) == falling[::-1] and len(set(rising)) == 2


def test_a_reference_is_previewed(report):
    pointed = """
        const link = document.querySelector('main p a[href="#figure_4_4"]');
        link.dispatchEvent(new PointerEvent("pointerover", { bubbles: true, pointerType: "mouse" }));
        await new Promise((resolve) => setTimeout(resolve, 500));
        const card = document.querySelector(".popover");
        return card.hidden ? null : [card.querySelector("img").getAttribute("src"), card.textContent];
    """
    source, words = report.run(pointed)
    assert source == "../figures/figure_4_4.svg" and "Figure" in words


def test_signs_as_printed_return_the_apparent_impedance_with_a_perfect_fit(report):
    cells = "[...document.querySelectorAll('[data-explore=apparent] tbody tr')]"
    cells += ".map((row) => row.lastChild.textContent)"
    *joint, vaf = report.run(f"return {cells}")
    # I + 2 I_leg, B, K - 2 m g r of the dummy (docs/method.md)
    assert joint == ["0.0610", "0.0649", "6.68"] and vaf == "100.00 %"
    consistent = "document.querySelectorAll('.explorer input[type=radio]')[1].click();"
    assert report.run(f"{consistent} return {cells}")[2:] == ["10.2", "100.00 %"]


def test_the_leg_of_the_page_agrees_with_the_forward_simulation_for_every_set_of_parameters(study, report):
    names = report.run(
        """
        const mount = document.querySelector(".explorer[data-explore=forward]");
        const select = mount.querySelector("select");
        return [...select.options].map((option) => option.value).filter(Boolean).map((name) => {
          select.value = name;
          select.dispatchEvent(new Event("change"));
          return [name, mount.querySelector("table tr:last-child td").textContent];
        });
        """
    )
    shown = {name: float(vaf.removesuffix(" %").replace("\u2212", "-")) for name, vaf in names}
    rows = FORWARD_SCORES.read(study / "results/tables/forward.csv")
    expected = {
        PARAMETER_SETS[row.parameter_set]: row.vaf_trial
        for row in rows
        if (row.condition, row.quantity) == ("sine-0.5", "theta")
    }
    assert len(expected) > 3 and shown == pytest.approx(expected, rel=0.01, abs=0.3)


def test_printed_cells_are_read_by_pointing_and_by_keys(report):
    about = "return document.querySelector('.cell-about').textContent;"
    cell = "document.querySelector('table.cells td[data-about]')"
    first = report.run(f"{cell}.dispatchEvent(new PointerEvent('pointerenter')); {about}")
    assert first.startswith("cellTable 4-1 of the thesis, I, 0.08") and "tolerance" in first
    press = (
        "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: given[0], bubbles: true}));"
    )
    report.run(f"{cell}.focus(); {press}", "ArrowDown")
    assert report.run(f"{press} {about}", "ArrowRight").startswith("cellTable 4-1 of the thesis, B, 0.12")


def test_a_page_of_a_trial_opens_without_errors(study, browser):
    browser.show(study / "results/report/trials/dummy/sine-0.5.html")
    assert browser.run("return document.querySelectorAll('canvas').length") > 3
    assert browser.log() == []
