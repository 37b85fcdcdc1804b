"""Signals as arrays: filters, resampling, spectra, perturbations, electromyograms."""
