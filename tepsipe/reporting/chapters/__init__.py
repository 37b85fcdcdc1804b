"""Per chapter of the report: numbers that are in no table, and the conditions of its sentences."""
