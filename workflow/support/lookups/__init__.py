"""Look-ups on the trials and settings of a study, each for one purpose; `Study` has one of each."""
