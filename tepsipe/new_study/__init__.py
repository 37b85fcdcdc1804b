"""From a folder of recordings to a study: trial sheet, configuration, and list of what is missing."""
