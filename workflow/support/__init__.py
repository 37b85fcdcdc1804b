"""What the rules need before the first job: checked configuration, trial sheet, reach of scripts."""
