"""Uncertainty budgets of the estimators: Type A of a fit and the sources of Type B, one by one."""
