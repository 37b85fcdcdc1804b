"""What a reader sees: the thesis's tables and statements, comparison with the truth, numbers and figures."""
