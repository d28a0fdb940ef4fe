"""``fmi-model.h``: what the checked-in wrapper (``c/``) must know of one sheet: its names, its variables, its period."""

from __future__ import annotations

from collections.abc import Sequence

from saoflow.codegen.interface import Interface
from saoflow.codegen.printer import real, safe
from saoflow.fmi.variables import Variable

_ROLES = {"input": "roleInput", "output": "roleOutput"}


def model_header(interface: Interface, variables: Sequence[Variable], period: float, token: str) -> str:
    """The text of the header. ``token``: the instantiation token (GUID), plain ASCII; ``period`` in s."""
    constants = [value for variable in variables if variable.variability == "constant" for value in variable.start]
    lines = [
        "/*",
        " * The sheet as the interface of FMI sees it. Generated; fmi-memory.h and fmi-unit.h say what it means.",
        " */",
        "#ifndef FMI_MODEL_H",
        "#define FMI_MODEL_H",
        "",
        "#include <stdbool.h>",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        f'#include "{interface.prefix}.h"',
        "",
        f"typedef {interface.real_type} ModelReal;",
        f"typedef {interface.input_struct} ModelInput;",
        f"typedef {interface.output_struct} ModelOutput;",
        f"typedef {interface.state_struct} ModelState;",
        "",
        f"#define modelInit {interface.init}",
        f"#define modelStep {interface.step}",
        "",
        '#include "fmi-memory.h"',
        "",
        f'static const char modelToken[] = "{safe(token)}";',
        f"static const double modelPeriod = {real(period, 64)};  /* s */",
        "",
        "/* Parameters: numbers since the code was generated. */",
        f"static const double modelConstants[{max(1, len(constants))}] = {{",
        *(f"    {real(float(value), 64)}," for value in constants or [0.0]),
        "};",
        "",
        f"static const uint32_t modelVariableCount = {len(variables)}u;",
        "",
        "/* By value reference. */",
        f"static const Variable modelVariables[{len(variables)}] = {{",
        *(_row(reference, variable) for reference, variable in enumerate(variables)),
        "};",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _row(reference: int, variable: Variable) -> str:
    comment = f"/* {reference}: {safe(variable.name)} */"
    size = f"{variable.size}u"
    if variable.place is None:
        return f"    {{kindTime, roleNone, 0u, {size}}}, {comment}"
    if isinstance(variable.place, int):
        return f"    {{kindConstant, roleNone, {variable.place}u, {size}}}, {comment}"
    kind = "kindBoolean" if variable.type == "Boolean" else "kindReal"
    role = _ROLES.get(variable.causality, "roleState")
    return f"    {{{kind}, {role}, offsetof(Memory, {variable.place}), {size}}}, {comment}"
