"""The numbers of the report as text, one module per chapter."""
