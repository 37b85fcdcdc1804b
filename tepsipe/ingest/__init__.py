"""From the contents of raw files to a `Trial` on one clock."""
