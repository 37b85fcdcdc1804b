"""Figures of the study: one style, one module per experiment or part, by its name.

Each of these modules has ``draw(files, chosen)``, which yields names and figures. ``files`` and ``chosen``
have the inputs and the params of the module's rule as attributes.
"""
