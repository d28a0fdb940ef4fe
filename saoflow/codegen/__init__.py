"""Printing C from a frame program; compiling and binding it."""
