"""Readers of the files that the instruments write. Each refuses an unusable file in one sentence."""
