"""Finding the reference of a sheet: by the sheet's name among the installed ones, or as ``module:name``."""

from __future__ import annotations

import importlib
import sys
from importlib.metadata import entry_points
from typing import Any

from saoflow import Diagnosis, DiagnosisError
from saoflow.diagnosis import did_you_mean
from verification.verifier.case import FunctionReference, Reference, ReferenceCase

GROUP = "saoflow.references"
"""The entry-point group: name of the sheet = module:object."""

SHIPPED = {
    "cmhe_fte": "verification.verifier.cases:cmhe_fte",
    "cmhe_fte_lean": "verification.verifier.cases:cmhe_fte_lean",
    "umhe_fte": "verification.verifier.cases:umhe_fte",
    "ekf_fte": "verification.verifier.cases:ekf_fte",
    "ekf": "verification.verifier.mho_cases:ekf",
    "mho_fault_detection": "verification.verifier.mho_cases:mho_fault_detection",
    "mho_pe": "verification.verifier.mho_cases:mho_pe",
    "mho_wd": "verification.verifier.mho_cases:mho_wd",
    "mho_wd_condensed": "verification.verifier.mho_cases:mho_wd_condensed",
    "mho_wod": "verification.verifier.mho_cases:mho_wod",
    "convexified_mhe": "verification.verifier.double_mhe_case:convexified_mhe",
    "cstr_ahead": "verification.verifier.cstr_case:cstr_ahead",
    "cstr_ahead_no_est": "verification.verifier.cstr_case:cstr_ahead_no_est",
    "cstr_mhe": "verification.verifier.cstr_case:cstr_mhe",
    "cstr_mhe_no_est": "verification.verifier.cstr_case:cstr_mhe_no_est",
    "double_mhe": "verification.verifier.double_mhe_case:double_mhe",
    "linearised_mhe": "verification.verifier.double_mhe_case:linearised_mhe",
    "nonlinear_mhe": "verification.verifier.double_mhe_case:nonlinear_mhe",
}
"""References that come with saoflow: found even where its entry points are not installed."""


def find_reference(sheet: str, given: str | None = None) -> tuple[Reference, str]:
    """Return the reference of the sheet of that name, and where it was found (``module:name``).

    ``given`` is ``module:name`` from the command line; a module in the working folder is found too.

    Raises :class:`saoflow.DiagnosisError`: E604 if there is none or it cannot be used, E603 for a ``given``
    that is no ``module:name``.
    """
    if given is not None:
        return _as_reference(_import(given), given), given
    known = SHIPPED | {entry.name: entry.value for entry in entry_points(group=GROUP)}
    if sheet not in known:
        raise _refused(
            "E604",
            f"there is no reference for the sheet `{sheet}`",
            f"the sheets with a reference are: {', '.join(sorted(known))}",
            did_you_mean(sheet, known)
            or f"name yours with --reference module:name, or in the entry-point group {GROUP}",
        )
    return _as_reference(_import(known[sheet]), known[sheet]), known[sheet]


def _import(text: str) -> Any:
    module_name, colon, attribute = text.partition(":")
    if not (colon and attribute.isidentifier() and all(part.isidentifier() for part in module_name.split("."))):
        raise _refused(
            "E603",
            f"--reference cannot be `{text}`",
            "a reference is named by its module and its name in it",
            "write --reference module:name, such as my_references:lag",
        )
    # A console script does not look in the working folder, where a user's own reference lies.
    if "" not in sys.path:
        sys.path.insert(0, "")
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name == module_name
        cause = f"there is no module `{module_name}`" if missing else f"{type(error).__name__}: {error}"
        raise _refused(
            "E604",
            f"the reference module `{module_name}` cannot be imported",
            cause,
            "run saoflow from the folder that holds the module, or install it" if missing else "mend the module",
        ) from error
    if not hasattr(module, attribute):
        names = [name for name in vars(module) if not name.startswith("_")]
        raise _refused(
            "E604",
            f"the module `{module_name}` has no `{attribute}`",
            f"its names are: {', '.join(names[:12]) or 'none'}",
            did_you_mean(attribute, names) or "name the function or reference that the module defines",
        )
    return getattr(module, attribute)


def _as_reference(found: Any, text: str) -> Reference:
    if isinstance(found, ReferenceCase | FunctionReference):
        return found
    if callable(found):
        return FunctionReference(found)
    raise _refused(
        "E604",
        f"`{text}` is no reference",
        f"its type is {type(found).__name__}",
        "name a function from a dictionary of input arrays to one of output arrays, or a ReferenceCase",
    )


def _refused(code: str, message: str, cause: str, remedy: str) -> DiagnosisError:
    return DiagnosisError([Diagnosis(code, message, cause=cause, remedy=remedy)])
