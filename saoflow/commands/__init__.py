"""The commands of the command line, one file each: thin shells over the Python API."""
