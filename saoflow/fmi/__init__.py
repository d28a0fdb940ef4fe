"""Export of a sheet as a functional mock-up unit (FMI 3.0 and 2.0, co-simulation), with C sources and a binary."""

from saoflow.fmi.unit import Unit, build_unit, frame_period, write_unit

__all__ = ["Unit", "build_unit", "frame_period", "write_unit"]
