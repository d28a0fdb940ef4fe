"""The README beside built C: how to compile it, how to call it, what is promised."""

from __future__ import annotations

from saoflow.codegen.frame_operations import Cost
from saoflow.codegen.generate import Code
from saoflow.codegen.printer import safe
from saoflow.scheduler.program import FrameProgram, ProgramPort
from saoflow.wires import unit_suffix

WARNINGS = "-std=c99 -pedantic -Wall -Wextra -Wconversion -Wdouble-promotion -Wfloat-equal -Werror"


def readme(code: Code, program: FrameProgram, cost: Cost, stack: str) -> str:
    """The text of README.md."""
    face = code.interface
    name = face.prefix
    kind = "double (binary64)" if program.real == 64 else "float (binary32)"
    counted = ", ".join(f"{n} {kind_}" for kind_, n in cost.kinds.items())
    same = "Which frame runs what is fixed" if cost.frames else "Every frame executes the same operations"
    return f"""# {name}

C99 of the sheet `{safe(program.sheet)}`, made by saoflow. Reals are {kind}. Do not edit; build again.

| file | holds |
|---|---|
| `{name}.h` | the interface: inputs, outputs, state |
| `{name}.c` | the code; every statement names its wire, sheet and line |
| `selfcheck.c` | recorded frames, compared bit by bit with saoflow's interpreter |
| `trace.json` | C line to wire, sheet and line (`c_to_sheet`), and back (`sheet_to_c`) |

## Compile

    cc {WARNINGS} \\
       -O2 -ffp-contract=off -c {name}.c

`-ffp-contract=off` is needed: a fused multiply-add rounds once where the sheet rounds twice. Never `-ffast-math` or any of
its parts; on 32-bit x86 use `-msse2 -mfpmath=sse`. No header, no library, no heap is needed.

    cc -O2 -ffp-contract=off {name}.c selfcheck.c -o selfcheck && ./selfcheck

prints how many outputs differ from the interpreter's, and exits 0 if none does. Only `selfcheck.c` uses `<stdio.h>`.

## Use

    {face.state_struct} state;
    {face.input_struct} input;
    {face.output_struct} output;
    {face.init}(&state);             /* before the first frame */
    {face.step}(&state, &input, &output);   /* once a frame */

The caller owns all memory. `state` may be copied to save it and put back to restore it.

{_table("Input", program.inputs, face.inputs)}

{_table("Output", (*program.outputs, *program.probes), face.outputs)}

## Cost and promises

- {cost.headline}: {counted or "none"}. {len(program.states)} values of state.
- Stack: {stack}.
- {same}: no loop whose count depends on data, no recursion, no heap, no global
  variable, no function pointer, no library. A look-up table searches in a fixed number of steps.
- The bits of saoflow's interpreter, NaN, infinities, denormals and signed zeros included (any NaN equals any NaN), on
  IEEE-754 hardware that rounds to nearest and does not flush denormals to zero.
- Any input may be any number, NaN and infinity too. An output's range is what the sheet makes it.
"""


def _table(title: str, ports: tuple[ProgramPort, ...], names: tuple[str, ...]) -> str:
    rows = [f"| {title} | size | unit | meaning |", "|---|---|---|---|"]
    for port, name in zip(ports, names, strict=True):
        size = " x ".join(map(str, port.type.shape))
        unit = "boolean" if port.type.boolean else unit_suffix(port.type.units).strip()
        rows.append(f"| `{name}` | {size} | {_cell(unit)} | {_cell(port.doc)} |")
    return "\n".join(rows)


def _cell(text: str) -> str:
    return safe(text).replace("|", "/")
