"""The documentation site: the pages in ``docs/``, and those that are made from symbols, library and flagship."""
