"""Names of the pathway and of those estimators that claims, figures or other experiments single out."""

PATHWAY = "admittance"
AS_PRINTED = "spectral-fit"
MODULUS = "spectral-fit-modulus"
PERIODS = "spectral-fit-periods"
REGRESSION = "period-regression"
POOLED = "time-domain-pooled"
# those with a block of rows in Table 4-1
IN_TABLE = (AS_PRINTED, PERIODS)
