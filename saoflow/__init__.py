"""saoflow: block diagrams in YAML from a restricted symbol set, run inside an operation budget.

import saoflow
sheet = saoflow.load("cmhe_fte")
print(sheet.budget())
out = sheet.simulator().run({"alpha": array_n_by_3, ...})
"""

from typing import TYPE_CHECKING, Any

from saoflow.diagnosis import Diagnosis, DiagnosisError

if TYPE_CHECKING:
    from saoflow.pipeline import LoadedSheet, load
    from saoflow.scheduler.simulator import Simulator, State

__all__ = ["Diagnosis", "DiagnosisError", "LoadedSheet", "Simulator", "State", "load"]
__version__ = "0.1.0"

_WHERE = {
    "LoadedSheet": "saoflow.pipeline",
    "load": "saoflow.pipeline",
    "Simulator": "saoflow.scheduler.simulator",
    "State": "saoflow.scheduler.simulator",
}


def __getattr__(name: str) -> Any:
    """Import the pipeline (and numpy with it) when it is first used: help and messages need none of it."""
    if name not in _WHERE:
        raise AttributeError(f"module 'saoflow' has no attribute '{name}'")
    import importlib

    found = getattr(importlib.import_module(_WHERE[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
