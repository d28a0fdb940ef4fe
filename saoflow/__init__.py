"""saoflow: block diagrams in YAML from a restricted symbol set, run inside an operation budget."""
