"""The language server: what an editor shows while a sheet is being written."""
