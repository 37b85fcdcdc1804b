"""The study's figures: one style, one module per experiment."""
