"""Values of the thesis: tables, misprints, tolerances of printed cells, and claims."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator

from tepsipe.quantities import NotNegative, Positive
from workflow.settings.section import Section, UnfitError, number, optional, setting, some

TableName = Literal["table_4_1", "table_4_2", "table_4_3", "table_4_4"]
Row = dict[str, float]
Factor = number(above=1)


class PrintedTable(Section):
    """Printed values of a table: quantity, condition and number."""

    unfolded = False

    I: Row = optional("inertia: {condition: printed value}")  # noqa: E741
    B: Row = optional("damping")
    K: Row = optional("stiffness")
    SEM_I: Row = optional("standard error of the inertia")
    SEM_B: Row = optional("standard error of the damping")
    SEM_K: Row = optional("standard error of the stiffness")
    error: Row = optional("error of the fit")
    VAF_perturbation: Row = optional("VAF of the perturbations")
    VAF_trial: Row = optional("VAF of the trial")
    VAF_cross_validated: Row = optional("VAF of other trials")
    VAF_theta_perturbation: Row = optional("VAF of the predicted angle in the perturbations")
    VAF_theta_trial: Row = optional("VAF of the predicted angle in the trial")


class Tables(Section):
    """Printed tables."""

    table_4_1: PrintedTable = optional("Table 4-1")
    table_4_2: PrintedTable = optional("Table 4-2")
    table_4_3: PrintedTable = optional("Table 4-3")
    table_4_4: PrintedTable = optional("Table 4-4; its conditions are the noisy signals")


class PrintedSegment(Section):
    """Printed properties of a segment of the dummy."""

    width_cm: float = setting("width", unit="cm", thesis="Table 2-2")
    depth_cm: float = setting("depth", unit="cm", thesis="Table 2-2")
    length_cm: float = setting("length", unit="cm", thesis="Table 2-2")
    mass_kg: float = setting("mass", thesis="Table 2-2")
    inertia_kgm2: float = setting("moment of inertia", thesis="Table 2-2")


class Values(Section):
    """Single values in the text."""

    coherence_minimum: float = setting("lowest coherence", thesis="4-1-1")
    eigenfrequency_hz: float = setting("eigenfrequency of the joint", thesis="4-1-1")
    log_rate_hz: float = setting("rate of the log", thesis="2-1-1")
    command_rate_hz: float = setting("rate of the torque command", thesis="2-1-1")
    force_rate_hz: float = setting("rate of the forces", thesis="2-1-2")
    marker_rate_hz: float = setting("rate of the motion capture", thesis="2-1-2")
    emg_rate_hz: float = setting("rate of the electromyograms", thesis="2-2")
    command_ms: float = setting("length of the command", unit="ms", thesis="2-1-2")
    marker_accuracy_mm: float = setting("accuracy of the motion capture", unit="mm", thesis="2-1-2")
    foot: PrintedSegment
    leg: PrintedSegment


class PrintedJoint(Section):
    """Parameters of a simulated joint."""

    I: float = setting("inertia", unit="N·m·s²/rad")  # noqa: E741
    B: float = setting("damping", unit="N·m·s/rad")
    K: float = setting("stiffness", unit="N·m/rad")


class Simulations(Section):
    """Parameters of the forward simulation in every condition of Tables 4-2 and 4-3."""

    every_condition: dict[str, PrintedJoint] = setting("{parameter set: parameters}")
    captions: dict[str, PrintedJoint] = setting(
        "{condition: parameters} of TEP-SIPE below a figure; other conditions have those of their table"
    )


class Slip(Section):
    """Evident misprint: tables show the printed value, captions the intended one."""

    table: str = setting("table")
    quantity: str = setting("row")
    condition: str = setting("column")
    printed: float = setting("printed value")
    meant: float = setting("intended value")


class Cell(Section):
    """Tolerance of printed cells, exactly one of `absolute`, `share`, `factor` and `unexplained_factor`."""

    tables: some(TableName) = setting("tables of the cells")
    rows: some(str) = setting("their quantities")
    verdict: Literal["fitted", "predicted", "interpretation", "unknown"] = setting(
        "verdict of simulated trials within the tolerance; `unknown` if no rule returns the printed value"
    )
    used: str = setting("name in `bases`: what was used to get the value")
    null_model: Literal["mean of the printed row", "table_4_1", "table_4_2", "table_4_3"] = optional(
        "null model: by default the mean of the printed row, or the same column of another table"
    )
    absolute: Positive = optional("tolerance in the unit of the row")
    share: Positive = optional("tolerance as a fraction of the printed number")
    factor: Factor = optional("factor either way")
    unexplained_factor: Factor = optional("factor of 100 % − VAF")
    digit: Positive = optional("last printed digit of a VAF, by default 0.01 %")
    zero: NotNegative = optional("with `factor`: largest value where 0 is printed")
    reason: str = setting("why the tolerance is so wide")
    outside: str = optional("what is known of values outside")


def _tolerance(value: Any) -> Any:
    number_found = isinstance(value, int | float) and not isinstance(value, bool) and value >= 0
    if not number_found and value not in ("below", "above"):
        raise UnfitError("to be a number of at least 0, or one of 'below', 'above'")
    return value


class Claim(Section):
    """Statement of the thesis that the study checks."""

    claim: str = setting("the statement in words")
    where: str = setting("its place in the thesis")
    measure: str = setting("name in `tepsipe/reporting/claims.py`")
    unit: str = setting("unit of the measure")
    reported: float = setting("value of the thesis")
    tolerance: Annotated[Any, AfterValidator(_tolerance)] = setting(
        "a number in `unit`, or `below` or `above` for values below or above `reported`"
    )
    verdict: Literal["implied", "fitted", "predicted", "pattern", "interpretation"] = setting(
        "verdict of a simulated trial within the tolerance; `implied` is measured on the printed values"
    )
    used: str = setting("name in `bases`: what was used to get the value")
    null_value: float = optional("value of a null model, by default by those of Tables 4-1 to 4-4")
    margin: float = optional(
        "value that the thesis itself has, by default that of its printed tables, if they determine it"
    )
    own_threshold: bool = optional("true if the thesis prints no such number and the threshold is ours")
    section: str = setting("section of the report that discusses the claim")
    outside: str = optional("what is known of a value outside, or the explanation that predicts one within")


class Assertion(Section):
    """Statement of chapters 4 to 6 of the thesis, with claims that test it or the reason why none does."""

    where: str = setting("its place in the thesis")
    says: str = setting("what the thesis says")
    measures: list[str] = optional("measures of the claims that test it")
    tables: list[TableName] = optional("printed tables whose cells test it")
    unchecked: str = optional("why it cannot be checked, without `measures` and `tables`")


class Reported(Section):
    """Values of the thesis."""

    tables: Tables
    values: Values
    bases: dict[str, str] = setting("{name: what values of the run are obtained from, in words}")
    simulations: Simulations
    slips: list[Slip] = setting("evident misprints")
    cells: list[Cell] = setting("tolerance of every printed cell")
    claims: list[Claim] = setting("statements that the study checks")
    assertions: list[Assertion] = setting("all statements of chapters 4 to 6, in their order")
