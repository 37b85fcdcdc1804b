"""Settings of a study as a whole, its folders, and many laboratories instead of one."""

from typing import Annotated

from pydantic import AfterValidator, Field

from workflow.settings.section import Section, UnfitError, fixed, number, optional, setting
from workflow.settings.virtual_lab import Distribution


class Study(Section):
    """The study as a whole."""

    name: str = setting(
        "file name of the report, lower-case letters, digits and hyphens, not beginning with a hyphen: "
        "`<results>/report/<name>.pdf`",
        pattern="^[a-z0-9][a-z0-9-]*$",
    )
    title: str = setting(
        "title of the report; of a study of other recordings that sets none, it names the trial sheet"
    )
    trial_sheet: str = setting("the trial sheet")
    recordings_folder: str = setting("base of relative paths in the trial sheet")
    recordings_source: str | None = setting(
        "origin of the recordings, printed on the first page of the report if all trials are recordings"
    )
    virtual_lab: str | None = setting(
        "constants of the virtual laboratory; null if all trials are recordings, without a comparison with "
        "the truth"
    )
    reported: str | None = setting(
        "values of the thesis; null without a comparison, and no claims are tested"
    )
    participants: str | None = setting(
        "table of the participants with their body mass, if the trial sheet names participants; see "
        "[below](#participants)"
    )
    seed: int = setting(
        "seed of all random numbers in the analysis: bootstrap, random starting values, noise", least=0
    )
    outside: bool = setting(
        "true if `pathvars` may lead out of the folder that the study runs in, for example to a large disk"
    )


class Pathvars(Section):
    """Folders of the outputs."""

    results: str = setting("folder of the results, its own")
    logs: str = setting("folder of the logs, its own")


def _other_than_shifted(name: str) -> str:
    if name == "shifted":
        raise UnfitError("to have another name than shifted", "rename it")
    return name


SetName = Annotated[str, Field(pattern="^[a-z][a-z0-9-]*$"), AfterValidator(_other_than_shifted)]
LeftOut = Annotated[str, Field(pattern=r"^(dummy|dummy\.foot|standing)\.(pathways|estimators)\.[^.]+$")]


class LaboratorySet(Section):
    """Laboratories of one kind. Without any of these keys (`{}`) they have the constants of the file."""

    shift: float = optional(
        "every mean in `drawn` moves by this number of standard deviations, up or down at random"
    )
    student_freedom: number(above=2) = optional(
        "every distribution becomes Student's with this number of degrees of freedom and the same standard "
        "deviation"
    )
    factors: dict[str, float] = optional("path of a constant: factor")
    constants: dict = optional("path of a constant: value")
    drawn: dict[str, Distribution] = optional(
        "constants that this set draws in addition, or in another way, as `drawn` of virtual_lab.yaml does"
    )


class Coverage(Section):
    """Many laboratories instead of one."""

    laboratories: int = setting(
        "number of laboratories; more of them leave those that are done as they are", least=1
    )
    seed: int = setting("from which, with the number of a laboratory, its seed follows", least=0)
    also_evaluated: list[fixed(str, 3)] = setting(
        "estimates that are evaluated as if they were recommended: lists of experiment, pathway and estimator"
    )
    left_out: list[LeftOut] = optional(
        "pathways and estimators that laboratories do without, as paths of keys (`standing.estimators.long`)"
    )
    drawn: dict[str, Distribution] = optional(
        "further constants that every laboratory draws, as `drawn` of virtual_lab.yaml does; the sets change "
        "none of these. If the rate of the cameras is drawn, `plate_treadmill.resample_rate_hz` follows it, "
        "and higher cutoffs of `standing` are lowered to 0.3 of it"
    )
    sets: Annotated[dict[SetName, LaboratorySet], Field(min_length=1)] = setting(
        "name of a set: what it changes. Laboratories 1, 3, 5, ... belong to the first set, 2, 4, 6, ... "
        "to the others in turn; with one set, all belong to it. `shifted` is no name of a set"
    )
