"""Record the expected person, who stands and is perturbed at belt, shank, thigh and pelvis, several times."""

import job

job.start(snakemake)

from tepsipe.virtual_lab.standing_chain import ChainPerson, chain_protocol, write_chain_trials

joints = snakemake.params.joints
write_chain_trials(
    snakemake.output.trials,
    ChainPerson(**joints["person"]),
    chain_protocol(joints["perturbations"], joints["protocol"], snakemake.params.engine),
    snakemake.params.seed,
    joints["persons"],
)
