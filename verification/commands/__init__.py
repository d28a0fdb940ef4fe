"""Commands that join ``saoflow`` through the entry-point group ``saoflow.commands``."""
