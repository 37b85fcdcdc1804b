"""What the trials of each experiment hold, as ingest compares it with their signals."""

from tepsipe.experiments.registry import EXPERIMENTS

# keys of the section `plausible` that describe rigs, not signals
RIG_KEYS = ("mass_fraction", "plate_offset_kg")
# where the mass of a weight is stated
OF_WEIGHTS = (
    "weight.weight.mass_kg, or for another weight mass_kg of the trial sheet and weight.further_weights"
)


def rig_of(settings: dict, experiment: str, amplitude: float | None = None) -> dict:
    """Arguments of `tepsipe.ingest.limits.Rig` for an experiment; none if it is not on the plate treadmill.

    The belt of `empty` carries less than half of the weight. The analysis compares the mass of a person,
    because it knows when the person stands still.

    amplitude: amplitude of the trial sheet (m/s).
    """
    if not EXPERIMENTS[experiment].on_plate:
        return {}
    section, limits = settings[experiment], settings["plausible"]
    rig: dict = {"amplitude_m_per_s": amplitude}
    if experiment == "empty":
        half = 0.5 * settings["weight"]["weight"]["mass_kg"]
        rig["belt"] = section.get("belt", settings["weight"]["belt"])
        return rig | {"carried_kg": (-half, half), "mass_key": "weight.weight.mass_kg"}
    rig["belt"] = section["belt"]
    if experiment == "dummy":
        geometry = section["geometry"]
        fixed = section["foot"]["belt_fixed_labels"]
        leg = [m["label"] for m in geometry["leg_markers"] if m["label"] not in fixed]
        mass = geometry["leg_mass_kg"] + geometry["foot_mass_kg"]
        rig |= {"carried_kg": _about(mass, limits), "mass_key": "the masses in dummy.geometry"}
        return rig | {"belt_fixed": fixed, "segments": {"leg": leg}}
    if experiment == "weight":
        mass = section["weight"]["mass_kg"]
        rig |= {"carried_kg": _about(mass, limits), "mass_key": OF_WEIGHTS}
        return rig | {"belt_fixed": section["files"]["marker_labels"]}
    person = section["person"]
    return rig | {"belt_fixed": [m["label"] for m in person["foot_markers"]], "person": True}


def _about(mass_kg: float, limits: dict) -> tuple[float, float]:
    """Lowest and highest mass that the plate may show."""
    within = max(limits["mass_fraction"] * mass_kg, limits["plate_offset_kg"])
    return mass_kg - within, mass_kg + within
