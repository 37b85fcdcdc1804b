"""Page of a trial of a spring."""

from tepsipe.drawing import header
from tepsipe.drawing.trial_page import Clock, Page, Panel, Section, Trace
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.trial import read_trial


def page(files, chosen) -> Page:
    """Torque of the spring."""
    trial, choices = read_trial(files.trial), header.choices_of_trial(files, chosen)
    trace = Trace("measured", trial.values("torque"), Clock.of(trial.time))
    facts = header.trial_facts(trial, "toy", choices)
    return Page(
        title=f"A toy, {choices['condition']}",
        study=choices["study"],
        header=header.facts_and_checks(facts, ESTIMATES.read(*files.estimates), [], choices),
        sections=(Section("Spring", (Panel("Torque", "N·m", (trace,)),)),),
        footer=header.sources_table(trial) + header.processing(trial),
    )
