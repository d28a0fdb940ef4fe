"""Reading YAML sheets and elaborating them; the shipped sheets lie beside it."""
