"""The figures of the study: one style, one module per experiment."""
