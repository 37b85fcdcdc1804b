"""Readers of the instruments' own files. Each refuses what it cannot read in one sentence."""
