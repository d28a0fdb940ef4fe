"""The symbol library: one file per symbol."""
