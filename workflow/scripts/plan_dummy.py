"""Plan the thesis's experiments on the dummy: what rig and protocol let them show."""

import job

job.start(snakemake)

from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.reporting.planned import PLANNED_ROWS, plan_of_thesis
from tepsipe.statistics.uncertainty import sources_of

geometry, joint = snakemake.params.geometry, snakemake.params.joint
rows = plan_of_thesis(
    Leg.from_settings(geometry),
    Foot.from_settings(geometry),
    Joint(joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"], joint["stiffness_Nm_per_rad"][0]),
    sources_of(snakemake.params.uncertainty),
)
PLANNED_ROWS.write(snakemake.output.table, rows)
