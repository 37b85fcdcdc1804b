"""The experiments of the study, one module or package each: from a `Trial` to estimates and results."""
