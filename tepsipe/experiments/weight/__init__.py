"""A weight on the belt, or nothing: belt-induced force (thesis sections 2-1-2 and 4-1-2)."""
