"""Flights: recording them with JSBSim, and making sensor readings, faults and gaps from their truth.

from verification.flights import Fault, load_recording, sensors

truth = load_recording("a320_calm_350kt_5000ft")
fault = Fault("runaway", "vc", which=(1, 2, 3), rate=-15.0, onset=20.0)
inputs = sensors(truth, seed=1, faults=[fault]).inputs()
"""

from verification.flights.catalogue import FLIGHTS, SHIPPED, find_flight
from verification.flights.fault_text import parse_fault, parse_missing
from verification.flights.faults import KINDS, TABLE_II, Fault, Missing, random_fault, table_ii_levels
from verification.flights.plan import AIRCRAFT, FlightPlan
from verification.flights.record import COLUMNS, record
from verification.flights.sensors import NO_NOISE, TABLE_I, Noise, sensors
from verification.recordings import Recording, load_recording, shipped_recordings, write_recording

__all__ = [
    "AIRCRAFT",
    "COLUMNS",
    "FLIGHTS",
    "KINDS",
    "NO_NOISE",
    "SHIPPED",
    "TABLE_I",
    "TABLE_II",
    "Fault",
    "FlightPlan",
    "Missing",
    "Noise",
    "Recording",
    "find_flight",
    "load_recording",
    "parse_fault",
    "parse_missing",
    "random_fault",
    "record",
    "sensors",
    "shipped_recordings",
    "table_ii_levels",
    "write_recording",
]
