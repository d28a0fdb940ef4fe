"""What can be refused before a campaign starts: sheets, their ports, the recorder."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from saoflow.codegen.objects import BackendWarning
from saoflow.diagnosis import Diagnoses, Diagnosis, DiagnosisError
from saoflow.scheduler.program import ProgramPort
from saoflow.scheduler.simulator import Simulator
from verification.campaigns.flights import is_kept
from verification.campaigns.plan import Campaign, DrawnFlights, Variant
from verification.campaigns.sheets import load_variant
from verification.campaigns.summary import OUTPUTS
from verification.campaigns.work import BACKEND
from verification.flights.faults import SENSORS
from verification.flights.record import jsbsim_module
from verification.recordings.recording import INERTIAL_INPUTS

_INPUTS = {**dict.fromkeys(SENSORS, (3,)), **dict.fromkeys(INERTIAL_INPUTS, ())}
_OUTPUTS = {name: (3,) if name.endswith(("_faulty", "_rms")) else () for name in OUTPUTS}


def check_campaign(campaign: Campaign) -> list[Diagnosis]:
    """Load, compile and try every sheet, so that processes find the compiled code; warnings come back.

    Raises DiagnosisError with all that is wrong: of loading, E805 (ports), E703 (jsbsim is missing and needed).
    """
    found = Diagnoses()
    for variant in campaign.sheets:
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                simulator = load_variant(variant).simulator(backend=BACKEND)
            found.extend(w.message.diagnosis for w in caught if isinstance(w.message, BackendWarning))
            wrong = list(_wrong_ports(variant, simulator))
            found.extend(wrong)
            if not wrong:
                _try(simulator)
        except DiagnosisError as error:
            found.extend(error.diagnoses)
    if any(True for _ in missing_flights(campaign)):
        try:
            jsbsim_module()
        except DiagnosisError as error:
            found.extend(error.diagnoses)
    found.raise_if_errors()
    return found.found


def missing_flights(campaign: Campaign) -> Iterator[tuple[DrawnFlights, int]]:
    """Drawn flights that runs need and that have not been recorded, by set and index."""
    used = {runs.flights for runs in campaign.runs}
    for flights in campaign.flights:
        if isinstance(flights, DrawnFlights) and flights.name in used:
            for index in range(flights.count):
                if not is_kept(flights, index):
                    yield flights, index


def _wrong_ports(variant: Variant, simulator: Simulator) -> Iterator[Diagnosis]:
    program = simulator.program
    for what, wanted, ports in (("input", _INPUTS, program.inputs), ("output", _OUTPUTS, program.outputs)):
        there = {port.name: port.type.shape for port in ports}
        for name, shape in wanted.items():
            if there.get(name) != shape:
                has = f"it is of shape {list(there[name])}" if name in there else f"it has no {what} of that name"
                yield _port(variant, what, name, f"{has}; it takes shape {list(shape)}")
        for port in ports if what == "input" else ():
            if port.name not in wanted:
                yield _port(variant, what, port.name, "no flight gives this input")


def _port(variant: Variant, what: str, name: str, cause: str) -> Diagnosis:
    message = f"`{variant.label}` cannot fly a campaign: {what} `{name}`"
    remedy = "give the sheet the ports of cmhe_fte (`saoflow show cmhe_fte`)"
    return Diagnosis("E805", message, cause=cause, remedy=remedy)


def _try(simulator: Simulator) -> None:
    """A frame alone and a frame of a batch: both are compiled before processes want them."""
    for lead in ((1,), (2, 1)):
        simulator.reset()
        simulator.run({port.name: np.zeros((*lead, *_shape(port))) for port in simulator.program.inputs})


def _shape(port: ProgramPort) -> tuple[int, ...]:
    return port.type.shape
