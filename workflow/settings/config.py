"""The whole configuration, and checks that compare its sections."""

from pydantic import create_model

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.mechanics.engines import installed_engines
from tepsipe.treadmill.options import BEST, FRAMES
from workflow.settings.check import check_content
from workflow.settings.complete import plate_key, settings_of
from workflow.settings.dummy import Dummy, Noise
from workflow.settings.plan import Plan
from workflow.settings.plate_treadmill import PlateTreadmill
from workflow.settings.platform import Platform
from workflow.settings.plausible import Plausible
from workflow.settings.position_manipulator import PositionManipulator
from workflow.settings.section import Section, UnfitError, made_from, refuse_unknown, setting
from workflow.settings.standing import Standing
from workflow.settings.study import Coverage, Pathvars, Study
from workflow.settings.uncertainty import Uncertainty
from workflow.settings.walking import Walking
from workflow.settings.weight import Belt, Empty, Weight
from workflow.settings.wristalyzer import Wristalyzer

# sections of experiments whose folder has the dataclass of their settings
OF_FOLDERS = {name: made_from(known.options) for name, known in EXPERIMENTS.items() if known.settings}
Folders = create_model(
    "Folders", __base__=Section, **{name: (kind, ...) for name, kind in OF_FOLDERS.items()}
)


class Config(Folders):
    """The configuration of a study."""

    study: Study
    pathvars: Pathvars
    coverage: Coverage | None = setting("many laboratories instead of one; null but for a coverage study")
    plan: Plan | None = setting("what an experiment will show; null but for a plan study")
    walking: Walking | None = setting("the ankle in walking; null but for a study of walking")
    plausible: Plausible
    wristalyzer: Wristalyzer
    plate_treadmill: PlateTreadmill
    dummy: Dummy
    position_manipulator: PositionManipulator
    platform: Platform
    noise: Noise
    weight: Weight
    empty: Empty
    standing: Standing
    belt: Belt
    uncertainty: Uncertainty


def check_config(config: dict, name: str) -> None:
    """Check every section, then what sections say about each other; raise one sentence."""
    check_content(config, Config, name)
    settings = settings_of(config)
    for check in (_cutoffs, _specification, _models_of_pathways, _plan):
        try:
            check(settings)
        except (UnfitError, InputError) as fault:
            text = fault.sentence() if isinstance(fault, UnfitError) else fault
            raise InputError(f"{name}: {text}") from None


def _cutoffs(config: dict) -> None:
    """Every cutoff must lie below half of the rate of what is filtered."""
    filters = []
    for section in ("wristalyzer", "position_manipulator"):
        keys = (f"{section}.analysis.lowpass_cutoff_hz", f"{section}.ingest.resample_rate_hz")
        filters.append((section, *keys, config[section]["analysis"]["lowpass_cutoff_hz"]))
    for section in ("dummy", "standing"):
        keys = [plate_key(config, section, key) for key in ("lowpass_cutoff_hz", "resample_rate_hz")]
        filters.append((section, *keys, config[section]["analysis"]["lowpass_cutoff_hz"]))
    first, *others = config["weight"]["analysis"]["cutoffs_hz"]
    rate_key = "plate_treadmill.resample_rate_hz"
    filters.append(("weight", "plate_treadmill.lowpass_cutoff_hz", rate_key, first))
    filters += [("weight", "weight.analysis.other_cutoffs_hz", rate_key, cutoff) for cutoff in others]
    for section, cutoff_key, rate_key, cutoff in filters:
        half = 0.5 * config[section]["ingest"]["resample_rate_hz"]
        if cutoff >= half:
            raise UnfitError(f"below half of {rate_key} ({half:g} Hz)", "lower it", cutoff_key, f"{cutoff:g}")
    if first in others:
        expected, found = "beside plate_treadmill.lowpass_cutoff_hz", f"{first:g} Hz for both"
        raise UnfitError(expected, "take it out", "weight.analysis.other_cutoffs_hz", found)


def _specification(config: dict) -> None:
    """The other filter must be another one, and below half of the rate."""
    dummy = config["dummy"]
    tried, cutoff = dummy["specification"]["other_cutoff_hz"], dummy["analysis"]["lowpass_cutoff_hz"]
    half = 0.5 * dummy["ingest"]["resample_rate_hz"]
    if tried == cutoff or tried >= half:
        cutoff_key, rate_key = (
            plate_key(config, "dummy", key) for key in ("lowpass_cutoff_hz", "resample_rate_hz")
        )
        expected = f"below half of {rate_key} ({half:g} Hz) and not {cutoff_key} ({cutoff:g} Hz)"
        raise UnfitError(expected, key="dummy.specification.other_cutoff_hz", found=f"{tried:g}")


def known_models(config: dict) -> list[str]:
    """Names of the models of the force plate that a pathway can take."""
    family = config["weight"]["models"]["family"]
    return [*family, BEST] if set(FRAMES) & set(family) else family


def _models_of_pathways(config: dict) -> None:
    """A pathway's model of the treadmill must be one that is fitted, or the best of the frames."""
    family = known_models(config)
    for section, pathways in (
        ("dummy.foot", config["dummy"]["foot"]["pathways"]),
        ("standing", config["standing"]["pathways"]),
    ):
        for pathway, choice in pathways.items():
            if choice["treadmill_model"] is not None:
                key = f"{section}.pathways.{pathway}.treadmill_model, if not null,"
                refuse_unknown(key, choice["treadmill_model"], "weight.models.family", family)


def _plan(config: dict) -> None:
    """A plan study tries filters on simulated trials with a treadmill model, and needs an engine."""
    if config["plan"] is None:
        return
    if config["study"]["virtual_lab"] is None or config["coverage"] is not None:
        found = "study.virtual_lab null" if config["study"]["virtual_lab"] is None else "coverage, too"
        raise InputError(
            f"expected a plan study of simulated trials, whose truth is known, found {found}: correct it, "
            "or set plan to null"
        )
    pathway = config["dummy"]["foot"]["pathways"].get("foot-compensated")
    if pathway is None or pathway["treadmill_model"] not in known_models(config):
        raise InputError(
            "expected weight.models.family to fit the treadmill_model of "
            "dummy.foot.pathways.foot-compensated for a plan study, found none: add it"
        )
    engine = config["dummy"]["simulation"]["engine"]
    bodies = {"pybullet", "mujoco"} & set(installed_engines())
    if not (engine in bodies or (engine not in ("pybullet", "mujoco") and bodies)):
        found = ", ".join(sorted(bodies)) or "none"
        raise InputError(
            f"expected PyBullet or MuJoCo for plan.several_joints, found {found} and dummy.simulation.engine "
            f"{engine}: install it, or set the engine to auto"
        )
