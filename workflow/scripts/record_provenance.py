"""Record inputs, code and environment of the study."""

import job

job.start(snakemake)

import hashlib
import json
import platform
from importlib.metadata import version

import yaml

from tepsipe.drawing.names import PARAMETER_SETS
from tepsipe.experiments.forward.scores import engine_of
from tepsipe.io.trial import read_sources
from tepsipe.mechanics.engines import engine_version

config = snakemake.params.config
raw = {}
for path in snakemake.input.trials:
    name, sources = read_sources(path)
    raw[name] = sources
packages = ("tepsipe", "snakemake", "numpy", "scipy", "pandas", "h5py", "ezc3d", "matplotlib", "typst")
name = snakemake.params.engine
engine = None
if name is not None:
    others = [one for one in PARAMETER_SETS if engine_of(one, name) != name]
    engine = {"name": name, "version": engine_version(name), "by_equations": others}
canonical = json.dumps(config, sort_keys=True).encode()
with open(snakemake.output.provenance, "w", encoding="utf-8") as file:
    json.dump(
        {
            "commit": snakemake.params.code["commit"],
            "date": snakemake.params.code["date"],
            "modified": snakemake.params.code["modified"],
            "python": platform.python_version(),
            "packages": {name: version(name) for name in packages},
            "engine": engine,
            "config_sha256": hashlib.sha256(canonical).hexdigest(),
            "seed": config["study"]["seed"],
            "files": snakemake.params.files,
            "raw_files": raw,
            "config": config,
        },
        file,
        indent=2,
        sort_keys=True,
    )
    file.write("\n")
with open(snakemake.output.config, "w", encoding="utf-8") as file:
    file.write("# The whole configuration of the run: defaults and what overrode them.\n")
    # a configuration in JSON is read as ordered dictionaries, which YAML cannot write
    yaml.safe_dump(json.loads(json.dumps(config)), file, sort_keys=False)
