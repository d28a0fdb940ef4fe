"""What a report shows, as plain data. Nothing here draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from saoflow.scheduler.budget import BudgetReport

Array = NDArray[np.float64]
Arrays = Mapping[str, Array]

ESTIMATOR_OUTPUTS = (
    *("alpha_hat", "vc_hat", "wx_hat", "wz_hat", "alpha_pred", "vc_pred"),
    *("alpha_rms", "vc_rms", "alpha_faulty", "vc_faulty", "configuration"),
)
"""A run with all of these among its outputs is drawn as an air-data estimator, any other wire by wire."""


@dataclass(frozen=True)
class Mark:
    """An instant to be marked in every plot: ``time`` [s] and a few words."""

    time: float
    text: str


@dataclass(frozen=True)
class Limits:
    """What estimates and residuals are judged against, in port units but for angles; None: not drawn."""

    alpha_threshold_deg: float | None = None
    vc_threshold_kt: float | None = None
    wx_bound_kt: float | None = None
    wz_bound_kt: float | None = None


@dataclass(frozen=True, eq=False)
class RunShown:
    """One column of plots: a run's label (the sheet's name), its outputs (frames, *shape) and its own instants."""

    label: str
    outputs: Arrays
    marks: tuple[Mark, ...] = ()

    @property
    def is_estimator(self) -> bool:
        """Whether the outputs are named as those of ``cmhe_fte``."""
        return all(name in self.outputs for name in ESTIMATOR_OUTPUTS)


@dataclass(frozen=True)
class Fact:
    """One line of the summary; ``holds`` None if there is nothing to hold."""

    label: str
    text: str
    holds: bool | None = None


@dataclass(frozen=True)
class TextTable:
    """A table of text: a title, a header, rows of as many cells, and a note below.

    The first ``words`` columns are words, the others numbers.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    words: int = 1


@dataclass(frozen=True, eq=False)
class Difference:
    """Distances from a reference: a quantity with its unit, and one curve (frames,) for each label."""

    quantity: str
    curves: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Report:
    """Everything on the page.

    ``time`` (frames,) [s]; ``inputs`` and ``truth`` may lack any name: ``inputs`` are those of the sheet,
    ``truth`` has alpha [rad], vc, wx, wz [kt] of shape (frames,); ``remarks`` are further sentences
    below the headings of the plots "wx", "wz" and "airspeed_error"; ``repeat`` are command lines.
    """

    title: str
    time: Array
    runs: tuple[RunShown, ...]
    lead: str = ""
    inputs: Arrays = field(default_factory=dict)
    truth: Arrays = field(default_factory=dict)
    limits: Limits = Limits()
    marks: tuple[Mark, ...] = ()
    remarks: Mapping[str, str] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    tables: tuple[TextTable, ...] = ()
    budget: BudgetReport | None = None
    differences: tuple[Difference, ...] = ()
    difference_note: str = ""
    repeat: tuple[str, ...] = ()
    version: str = ""
