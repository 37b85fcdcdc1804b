"""Creation of a study from a folder of recordings: trial sheet, configuration, and list of missing items."""
