"""One experiment of the study each: from a `Trial` to estimates and results."""
