"""Drawings of sheets: pages and pictures, made from the netlist and the frame program that run."""
