"""Pages of a run for a web browser, one per trial and the index: files of HTML that load no script.

The module of an experiment has ``page(files, chosen)``, which returns the page of a trial. ``files`` and
``chosen`` have the inputs and the params of the module's rule as attributes.
"""
