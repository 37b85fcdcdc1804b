"""Fit one trial by the fit of its experiment."""

import job

job.start(snakemake)

from importlib import import_module

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result, write_result
from tepsipe.io.trial import read_trial

params, output, given = snakemake.params, snakemake.output, dict(snakemake.params.given)
models = getattr(snakemake.input, "models", None)
calibrations = getattr(snakemake.input, "calibrations", None)
if models is not None:
    # imported by name: a fit that takes no models does not depend on this module, one that does imports it
    registry = import_module("tepsipe.treadmill.registry")
    given["models"] = [registry.load_treadmill_models(path) for path in models]
    given["calibrations"] = [read_result(path) for path in calibrations]
fit = import_module(params.module).fit
fitted = fit(read_trial(snakemake.input.trial), params.section, snakemake.wildcards.condition, **given)
write_result(output.fit, fitted.result)
for name, result in fitted.further.items():
    write_result(output[name], result)
ESTIMATES.write(output.estimates, fitted.estimates)
uncertainty = getattr(snakemake.output, "uncertainty", None)
if uncertainty is not None:
    CONTRIBUTIONS.write(uncertainty, fitted.contributions)
