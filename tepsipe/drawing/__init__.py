"""What figures and pages share: one style, names, the picture of a file's contents, and the page of a trial.

The module ``figures`` of an experiment has functions ``draw_<name>(files, chosen)``, which yield names and
figures. Its module ``page`` has ``page(files, chosen)``, which returns the page of a trial for a web browser:
a file of HTML that loads no script. ``files`` and ``chosen`` have the inputs and the params of the rule as
attributes.
"""
