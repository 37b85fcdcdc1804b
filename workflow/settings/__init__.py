"""Typed model of the configuration: types, units, physical ranges and documentation of every setting.

It is imported once per run, when the study starts; jobs receive plain dictionaries and import none of it.
"""
