"""saoflow: block diagrams in YAML from a restricted symbol set, run inside an operation budget.

    import saoflow
    sheet = saoflow.load("cmhe_fte")
    print(sheet.budget())
    out = sheet.simulator().run({"alpha": array_n_by_3, ...})
"""

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.pipeline import LoadedSheet, load
from saoflow.scheduler.simulator import Simulator, State

__all__ = ["Diagnosis", "DiagnosisError", "LoadedSheet", "Simulator", "State", "load"]
__version__ = "0.1.0"
