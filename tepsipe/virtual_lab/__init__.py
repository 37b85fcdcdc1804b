"""The virtual laboratory: rigs, subjects and instruments that stand in for unpublished recordings.

It integrates the full non-linear mechanics and writes the files that the instruments would have
written. It imports nothing from the analysis, the analysis imports nothing from it, and its
constants (the truth) are read by nothing but the rule that makes raw files and the report's
comparison.
"""
