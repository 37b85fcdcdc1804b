"""Pages of a run for a web browser, one per trial and the index: files of HTML that load no script."""
