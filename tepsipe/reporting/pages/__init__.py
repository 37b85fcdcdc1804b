"""Pages of a run for a web browser: one per trial, and the index. A page is one file, which loads no other."""
