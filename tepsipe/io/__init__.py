"""Files: trials, results and tables of the study, and readers of the instruments' own kinds."""
