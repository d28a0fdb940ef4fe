"""Cycles and time of a frame on a target, two ways: every operand from memory and back, and registers kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from saoflow.diagnosis import Diagnosis, DiagnosisError
from saoflow.operations import Kind, Table
from saoflow.scheduler.program import FrameProgram, ProgramBody
from saoflow.targets.early_schedule import scheduled_early
from saoflow.targets.instructions import Instruction, Machine
from saoflow.targets.memory_form import memory_form
from saoflow.targets.peephole import call_counts, inlined, shared
from saoflow.targets.pipeline import cycles
from saoflow.targets.register_form import register_form
from saoflow.targets.scheduling import scheduled
from saoflow.targets.target import InstructionSet, Target

CAVEAT = (
    "An estimate from published pipeline models, not a worst-case execution time: no caches, no memory system, "
    "every branch predicted, nothing else running."
)
"""What the number is not: stands beside it wherever it is shown."""

FORMS = {"memory": "every operand from memory and back", "registers": "registers kept"}
"""The two ways, with what they mean."""


@dataclass(frozen=True, slots=True)
class BodyCost:
    """One body (a procedure, or the frame itself): how often a frame runs it, and what one run costs."""

    name: str
    times: int
    instructions: int
    cycles: int


@dataclass(frozen=True, slots=True, eq=False)
class FormCost:
    """One way of running a frame: machine instructions and cycles."""

    form: str
    instructions: int
    cycles: int
    kinds: Counter[Machine]
    bodies: tuple[BodyCost, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FrameCost:
    """A frame on a target, at a clock, against the frame period and the share of it that is allowed."""

    sheet: str
    target: Target
    real: int
    clock_mhz: float
    assumed_clock: bool
    period: float | None
    share: float | None
    """Part of the period that a frame may take, 0 to 1; None: no limit."""
    forms: tuple[FormCost, ...]
    """Memory, then registers."""

    def microseconds(self, form: FormCost) -> float:
        """Time of a frame in us."""
        return form.cycles / self.clock_mhz

    def part_of_period(self, form: FormCost) -> float | None:
        """Time of a frame as a part of the period."""
        return None if self.period is None else self.microseconds(form) * 1e-6 / self.period

    @property
    def over(self) -> bool:
        """Whether the dearer way takes more than its share of the period (of all of it where no share is given)."""
        parts = [self.part_of_period(form) for form in self.forms]
        return any(part is not None and part > (self.share or 1.0) for part in parts)

    def raise_if_over(self) -> None:
        """Raise DiagnosisError E401 if a frame takes more than its share of the period."""
        if not self.over:
            return
        assert self.period is not None
        slowest = max(self.forms, key=lambda form: form.cycles)
        allowed = (self.share or 1.0) * self.period * 1e6
        raise DiagnosisError(
            [
                Diagnosis(
                    "E401",
                    f"a frame of `{self.sheet}` takes {self.microseconds(slowest):.0f} us on {self.target.name}, "
                    f"{allowed:.0f} us allowed",
                    cause=f"{FORMS[slowest.form]}: {slowest.cycles} cycles at {self.clock_mhz:g} MHz",
                    remedy="make the costly sub-sheets cheaper, allow a larger --share, or name a faster target",
                )
            ]
        )

    def to_dict(self) -> dict[str, object]:
        """The machine-readable form."""
        return {
            "target": self.target.name,
            "title": self.target.title,
            "real": self.real,
            "clock_mhz": self.clock_mhz,
            "clock_assumed": self.assumed_clock,
            "period_s": self.period,
            "share": self.share,
            "over": self.over,
            "worst_case_execution_time": False,
            "caveat": CAVEAT,
            "notes": list(self.target.notes),
            "forms": {
                form.form: {
                    "instructions": form.instructions,
                    "cycles": form.cycles,
                    "time_us": self.microseconds(form),
                    "part_of_period": self.part_of_period(form),
                    "kinds": {kind.value: form.kinds[kind] for kind in Machine if form.kinds[kind]},
                    "bodies": [
                        {"name": b.name, "times": b.times, "instructions": b.instructions, "cycles": b.cycles}
                        for b in form.bodies
                    ],
                }
                for form in self.forms
            },
        }


def frame_cost(
    program: FrameProgram,
    target: Target,
    *,
    clock_mhz: float | None = None,
    period: float | None = None,
    share: float | None = None,
) -> FrameCost:
    """What a frame costs on a target; ``period`` in s. Raises DiagnosisError E603 for a clock or share out of range."""
    found = [
        *_out_of_range("--clock", clock_mhz, 0.001, 1e5, "a clock in MHz, such as 400"),
        *_out_of_range("--share", share, 1e-9, 1.0, "a part of the frame period, such as 0.1"),
    ]
    if share is not None and period is None:
        cause = "the sheet's budget states no period"
        found.append(
            Diagnosis("E603", "`--share` needs a frame period", cause=cause, remedy="add `period:` to `budget:`")
        )
    if found:
        raise DiagnosisError(found)
    isa = target.instruction_set
    bodies = inlined(program)
    forms = (
        _form("memory", program, program.bodies, memory_form, isa, target, False),
        _form("registers", program, bodies, partial(register_form, called=_called(bodies)), isa, target, True),
    )
    clock = target.clock_mhz if clock_mhz is None else clock_mhz
    return FrameCost(program.sheet, target, program.real, clock, clock_mhz is None, period, share, forms)


def _out_of_range(option: str, value: float | None, low: float, high: float, what: str) -> list[Diagnosis]:
    if value is None or low <= value <= high:
        return []
    return [Diagnosis("E603", f"`{option}` cannot be {value:g}", cause="it is out of range", remedy=f"give {what}")]


def _called(bodies: Sequence[ProgramBody]) -> frozenset[int]:
    """Tables looked up in more than one place: compilers make a function of such a look-up."""
    places = Counter(o.detail for body in bodies for o in body.operations if o.kind is Kind.LOOKUP)
    return frozenset(table for table, n in places.items() if n > 1)


Former = Callable[[ProgramBody, Sequence[Table], InstructionSet, bool], list[Instruction]]


def _form(
    name: str,
    program: FrameProgram,
    bodies: Sequence[ProgramBody],
    former: Former,
    isa: InstructionSet,
    target: Target,
    optimised: bool,
) -> FormCost:
    """Every body once, weighted by how often a frame runs it; what runs more seldom counts as in a frame in which all of it runs."""
    procedures = len(program.procedures)
    kinds: Counter[Machine] = Counter()
    costs: list[BodyCost] = []
    for i, (body, times) in enumerate(zip(bodies, call_counts(bodies, procedures), strict=True)):
        if not times:
            continue
        if optimised:
            body = scheduled_early(shared(body), target, program.real, i < procedures)
        instructions = former(body, program.tables, isa, i < procedures)
        for kind, n in Counter(x.kind for x in instructions).items():
            kinds[kind] += n * times
        if optimised:
            instructions = scheduled(instructions, target, program.real)
        costs.append(BodyCost(body.name, times, len(instructions), cycles(instructions, target, program.real)))
    return FormCost(
        name,
        sum(c.times * c.instructions for c in costs),
        sum(c.times * c.cycles for c in costs),
        kinds,
        tuple(costs),
    )
