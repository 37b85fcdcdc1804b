"""Tables and claims of the thesis, comparison with the truth, and numbers and figures of the report."""
