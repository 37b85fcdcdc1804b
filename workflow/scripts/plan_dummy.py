"""Plan the thesis's experiments on the dummy: what rig and protocol let them show."""

import job

job.start(snakemake)

from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.reporting.planned import PLANNED_ROWS, plan_of_thesis
from tepsipe.statistics.uncertainty import sources_of

geometry, joint = snakemake.params.geometry, snakemake.params.joint
rows = plan_of_thesis(
    Leg(
        mass_kg=geometry["leg_mass_kg"],
        com_m=geometry["leg_com_m"],
        inertia_kgm2=geometry["leg_inertia_kgm2"],
        gravity_m_per_s2=geometry["gravity_m_per_s2"],
    ),
    Foot(mass_kg=geometry["foot_mass_kg"], height_m=geometry["foot_height_m"]),
    Joint(joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"], joint["stiffness_Nm_per_rad"][0]),
    sources_of(snakemake.params.uncertainty),
)
PLANNED_ROWS.write(snakemake.output.table, rows)
