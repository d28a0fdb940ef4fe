"""From an operand as written (``stages.P_f[:-1]``, ``-KPi``, ``diag(R)``, ``2*gain``) to a wire."""

from __future__ import annotations

import numpy as np

from saoflow.blocks.constant import Value
from saoflow.blocks.library import SYMBOLS, AnySymbol
from saoflow.blocks.mul import Product
from saoflow.blocks.select import Selection, Span
from saoflow.diagnosis import Position, did_you_mean
from saoflow.diagrams.expression import (
    Array,
    Binary,
    Call,
    Expression,
    Index,
    Member,
    Name,
    Number,
    Slice,
    Text,
    Unary,
)
from saoflow.diagrams.expression_value import Quantity, names_in
from saoflow.diagrams.netlist import POISON, Node
from saoflow.diagrams.parameter_arithmetic import CONSTANTS
from saoflow.diagrams.scope import POISONED, Ports, Scope

SELECT, TRANSPOSE, DIAGONAL = SYMBOLS["select"], SYMBOLS["transpose"], SYMBOLS["diagonal"]
CONCATENATE, CONSTANT, MUL = SYMBOLS["concatenate"], SYMBOLS["constant"], SYMBOLS["mul"]


class Operands:
    """Resolves the operands of one block; the wiring it needs becomes nodes named after the block."""

    def __init__(self, scope: Scope, path: str) -> None:
        self.scope = scope
        self.path = path
        self._made = 0

    def wire(self, expression: Expression) -> int:
        """The wire that an operand means; POISON after a diagnosis."""
        match expression:
            case Name():
                return self._name(expression)
            case Number():
                return self.constant(Quantity(np.array(expression.value), None), expression.position)
            case Member():
                return self._member(expression)
            case Index():
                return self._index(expression)
        if self._is_constant(expression):
            return self._constant_expression(expression)
        match expression:
            case Unary(operator="-"):
                wire = self.wire(expression.operand)
                minus = self.constant(Quantity(np.array(-1.0), None), expression.position)
                return self._node(MUL, Product(False, False), (minus, wire), expression.position)
            case Unary():
                return self.wire(expression.operand)
            case Call():
                return self._call(expression)
            case Array():
                wires = tuple(self.wire(item) for item in expression.items)
                return self._node(CONCATENATE, "new", wires, expression.position)
        return self._refuse(expression)

    def signed_wire(self, expression: Expression) -> tuple[int, int]:
        """The sign and the wire of an operand of a sum: ``-x`` is (-1, x)."""
        sign = 1
        while isinstance(expression, Unary) and not self._is_constant(expression):
            sign = -sign if expression.operator == "-" else sign
            expression = expression.operand
        return sign, self.wire(expression)

    def slice_of(self, expression: Expression, i: int, count: int) -> int:
        """The i-th slice of a stack along its leading axis, which must have ``count`` slices."""
        ports = self._stack(expression)
        if ports is not None and len(ports) == count:
            return ports[i]
        return self._node(SELECT, Selection((i,), count), (self.wire(expression),), expression.position)

    def constant(self, quantity: Quantity, position: Position) -> int:
        """A constant node for a number."""
        value = Value(np.asarray(quantity.array, dtype=np.float64), quantity.unit)
        return self._node(CONSTANT, value, (), position)

    def stack(self, wires: tuple[int, ...], position: Position) -> int:
        """Wires joined along a new first axis."""
        return self._node(CONCATENATE, "new", wires, position)

    def _node(self, symbol: AnySymbol, configuration: object, inputs: tuple[int, ...], position: Position) -> int:
        if POISON in inputs:
            return POISON
        self._made += 1
        wire = self.scope.new_wire()
        self.scope.nodes.append(
            Node(
                f"{self.path}#{self._made}",
                position,
                symbol,
                configuration,
                None,
                inputs,
                (position,) * len(inputs),
                (wire,),
            )
        )
        return wire

    def _is_constant(self, expression: Expression) -> bool:
        names = list(names_in(expression))
        scope = self.scope
        return all(n.text in scope.parameters or n.text in ("pi", "true", "false") for n in names) and all(
            n.text not in scope.inputs and n.text not in scope.blocks for n in names
        )

    def _constant_expression(self, expression: Expression) -> int:
        quantity = self.scope.value_of(expression)
        return POISON if quantity is None else self.constant(quantity, expression.position)

    def _name(self, name: Name) -> int:
        scope = self.scope
        if name.text in scope.inputs:
            return scope.inputs[name.text]
        if name.text in scope.blocks:
            ports = scope.blocks[name.text]
            return self._only_port(ports, name)
        if name.text in scope.parameters:
            return self._parameter(name)
        if name.text in CONSTANTS:
            return self.constant(CONSTANTS[name.text], name.position)
        return scope.unknown_wire(name.text, name.position)

    def _parameter(self, name: Name) -> int:
        scope = self.scope
        if name.text not in scope.constants:
            quantity = scope.parameters[name.text]
            if quantity.text is not None:
                return scope.report(
                    "E218",
                    f"parameter `{name.text}` is a word, not a number",
                    name.position,
                    f"its value is `{quantity.text}`",
                    "connect a wire or a number",
                )
            wire = scope.new_wire()
            value = Value(np.asarray(quantity.array, dtype=np.float64), quantity.unit)
            scope.nodes.append(Node(name.text, name.position, CONSTANT, value, None, (), (), (wire,)))
            scope.constants[name.text] = wire
        return scope.constants[name.text]

    def _only_port(self, ports: Ports, name: Name) -> int:
        if ports is POISONED:
            return POISON
        if len(ports.names) != 1:
            return self.scope.report(
                "E203",
                f"`{name.text}` has {len(ports.names)} outputs",
                name.position,
                f"they are: {', '.join(ports.names) or 'none'}",
                f"name the one you mean: {name.text}.{ports.names[0]}" if ports.names else "give the sheet an output",
            )
        return self._port(ports, ports.names[0], name.position)

    def _port(self, ports: Ports, port: str, position: Position) -> int:
        wires = tuple(instance[port] for instance in ports.instances)
        return self.stack(wires, position) if ports.stacked else wires[0]

    def _member(self, member: Member) -> int:
        base = member.base
        if isinstance(base, Name) and base.text in self.scope.blocks:
            ports = self.scope.blocks[base.text]
            if ports is POISONED:
                return POISON
            if member.name in ports.names:
                return self._port(ports, member.name, member.position)
            if member.name != "T":
                return self._unknown_port(base.text, ports, member)
        if member.name == "T":
            return self._node(TRANSPOSE, None, (self.wire(base),), member.position)
        if isinstance(base, Name) and base.text not in self.scope.known():
            return self.scope.unknown_wire(base.text, base.position)
        return self.scope.report(
            "E203",
            f"there is no port `{member.name}` here",
            member.position,
            "only blocks that are sheets have named outputs",
            "leave it out, or write .T for the transpose",
        )

    def _unknown_port(self, block: str, ports: Ports, member: Member) -> int:
        return self.scope.report(
            "E203",
            f"`{block}` has no output `{member.name}`",
            member.position,
            f"its outputs are: {', '.join(ports.names) or 'none'}",
            did_you_mean(member.name, ports.names) or "name one of them",
        )

    def _stack(self, expression: Expression) -> tuple[int, ...] | None:
        """The instance wires, if the expression is an output of a fold or map."""
        port: str | None = None
        if isinstance(expression, Member) and isinstance(expression.base, Name):
            name, port = expression.base.text, expression.name
        elif isinstance(expression, Name):
            name = expression.text
        else:
            return None
        ports = self.scope.blocks.get(name)
        if ports is None or not ports.stacked or name in self.scope.inputs:
            return None
        if port is None and len(ports.names) == 1:
            port = ports.names[0]
        if port not in ports.names:
            return None
        return tuple(instance[port] for instance in ports.instances)

    def _index(self, expression: Index) -> int:
        indices = [self._one_index(i) for i in expression.indices]
        if any(i is None for i in indices):
            return POISON
        chosen = tuple(i for i in indices if i is not None)
        stack = self._stack(expression.base)
        if stack is not None:
            first, rest = chosen[0], chosen[1:]
            if isinstance(first, int) and -len(stack) <= first < len(stack):
                wire = stack[first]
                return self._node(SELECT, Selection(rest), (wire,), expression.position) if rest else wire
            if isinstance(first, Span) and stack[first.start : first.stop] and not rest:
                return self.stack(stack[first.start : first.stop], expression.position)
        wire = self.wire(expression.base)
        return self._node(SELECT, Selection(chosen), (wire,), expression.position)

    def _one_index(self, index: Expression | Slice) -> int | Span | None:
        if isinstance(index, Slice):
            ends = [None if end is None else self.whole_number(end, "an index") for end in (index.start, index.stop)]
            missing = [
                end is not None and got is None for end, got in zip((index.start, index.stop), ends, strict=True)
            ]
            return None if any(missing) else Span(*ends)
        return self.whole_number(index, "an index")

    def whole_number(self, expression: Expression, what: str) -> int | None:
        """The value of an expression that must be a whole number; None after a diagnosis (E216)."""
        quantity = self.scope.value_of(expression)
        if quantity is None:
            return None
        value = np.asarray(quantity.array, dtype=np.float64) if quantity.text is None else np.array(np.nan)
        if value.ndim or not np.isfinite(value) or value != np.floor(value):
            shown = (
                quantity.text if quantity.text is not None else (f"{float(value):g}" if not value.ndim else "an array")
            )
            self.scope.report(
                "E216",
                f"{what} must be a whole number",
                expression.position,
                f"it is {shown}",
                "write a whole number, or an expression of parameters that gives one",
            )
            return None
        return int(value)

    def _call(self, call: Call) -> int:
        if call.function.text == "diag" and len(call.arguments) == 1:
            return self._node(DIAGONAL, None, (self.wire(call.arguments[0]),), call.position)
        return self._refuse(call)

    def _refuse(self, expression: Expression) -> int:
        if isinstance(expression, Text):
            what = f"`{expression.text}` is no wire"
        elif isinstance(expression, Binary):
            what = "wires are not computed inside an operand"
        else:
            what = "this cannot be wired"
        unknown = [n for n in names_in(expression) if n.text not in self.scope.known() and n.text != "diag"]
        for name in unknown:
            self.scope.unknown_wire(name.text, name.position)
        if unknown:
            return POISON
        return self.scope.report(
            "E218",
            what,
            expression.position,
            "operands are wires, their elements and slices, -x, x.T, diag(x), [a, b], and arithmetic on parameters",
            "give the computation a block of its own: {add: [a, b]} or {mul: [a, b]}",
        )
