"""Preparation before the first job: checked configuration, trial sheet, modules that scripts import."""
