"""The numbers of a sheet's parameters: given where the sheet is used, inherited, or defaults."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from saoflow.diagnosis import Note, Position, did_you_mean
from saoflow.diagrams.expression import Expression
from saoflow.diagrams.expression_value import Quantity, names_in
from saoflow.diagrams.loops import is_loop, strong_components
from saoflow.diagrams.scope import Scope
from saoflow.diagrams.sheet import Argument, ParameterDeclaration, Sheet
from saoflow.units import Unit, conversion_hint


@dataclass(frozen=True, slots=True)
class ParameterValues:
    """Every parameter of a sheet with its value; ``broken``: those that are already diagnosed."""

    values: tuple[tuple[str, Quantity], ...]
    broken: tuple[str, ...] = ()


def key_of(values: ParameterValues) -> object:
    """Equal for equal numbers and units: the key under which a structure is remembered."""
    return tuple(
        (name, np.asarray(q.array, dtype=np.float64).tobytes(), np.shape(q.array), q.unit, q.text)
        for name, q in values.values
    )


def settle(
    scope: Scope, sheet: Sheet, arguments: Sequence[Argument], extra: Mapping[str, Quantity], used: Position
) -> ParameterValues | None:
    """The parameters of ``sheet`` where it is used in the sheet of ``scope``; None after a diagnosis.

    ``extra`` holds names that only the arguments may use (``index`` of a fold).
    """
    names = {**scope.parameters, **extra}
    given: dict[str, Quantity] = {}
    places: dict[str, Position] = {}
    failed: set[str] = set()
    fine = True
    declared = {p.name.text: p for p in sheet.parameters}
    for argument in arguments:
        name = argument.name.text
        if name not in declared:
            near = did_you_mean(name, [*declared, *(i.name.text for i in sheet.inputs)])
            scope.report(
                "E206",
                f"`{sheet.name.text}` has no parameter `{name}`",
                argument.name.position,
                f"its parameters are: {', '.join(declared) or 'none'}",
                near or "leave it out",
            )
            fine = False
            continue
        expression = scope.expression_of(argument)
        quantity = None if expression is None else scope.value_of(expression, names)
        checked = None if quantity is None else _with_unit(scope, quantity, declared[name], argument.position)
        if checked is None:
            failed.add(name)
        else:
            given[name] = checked
            places[name] = argument.position
    values = complete(scope, sheet, given, scope.parameters, used, scope.broken_parameters | failed, places)
    return values if fine and not failed and not values.broken else None


def complete(
    scope: Scope,
    sheet: Sheet,
    given: Mapping[str, Quantity],
    around: Mapping[str, Quantity],
    used: Position | None,
    silent: set[str],
    places: Mapping[str, Position] | None = None,
) -> ParameterValues:
    """Add inherited values and defaults to what is given. Defaults may use the other parameters of the sheet.

    ``silent`` names parameters around whose absence is already diagnosed; ``places`` tells where what is given stands.
    """
    places = places or {}
    values: dict[str, Quantity] = {}
    ordered, broken = _by_dependence(scope, sheet, given)
    for declaration in ordered:
        name = declaration.name.text
        quantity: Quantity | None = None
        place, source = places.get(name), ""
        if name in given:
            quantity = given[name]
            source = "" if place is not None else ", as it is given to the sheet (`--set`)"
        elif declaration.value is not None:
            place = declaration.value.position
            if not _uses_any(declaration.value, broken):
                quantity = scope.value_of(declaration.value, values)
            if quantity is not None:
                quantity = _with_unit(scope, quantity, declaration, declaration.value.position)
        elif declaration.inherited and name in around:
            place, source = used, ", inherited from this sheet"
            quantity = _with_unit(scope, around[name], declaration, declaration.name.position)
        elif name not in silent:
            _no_value(scope, sheet, declaration, used)
        if quantity is not None and not _uses_any(declaration.range, broken):
            quantity = quantity if _in_range(scope, quantity, declaration, values, place, source) else None
        if quantity is None:
            broken.append(name)
        else:
            values[name] = quantity
    return ParameterValues(tuple(values.items()), tuple(broken))


def _uses_any(expression: Expression | None, names: Collection[str]) -> bool:
    return expression is not None and any(n.text in names for n in names_in(expression))


def _by_dependence(
    scope: Scope, sheet: Sheet, given: Mapping[str, Quantity]
) -> tuple[list[ParameterDeclaration], list[str]]:
    """The declarations, each after those that its default and range use; and those in circles, which are diagnosed."""
    declared = {p.name.text: i for i, p in enumerate(sheet.parameters)}

    def uses(i: int) -> list[int]:
        declaration = sheet.parameters[i]
        read = [declaration.range] if declaration.name.text in given else [declaration.value, declaration.range]
        return [declared[n.text] for e in read if e is not None for n in names_in(e) if n.text in declared]

    ordered: list[ParameterDeclaration] = []
    circular: list[str] = []
    for component in strong_components(range(len(sheet.parameters)), uses):
        first = sheet.parameters[min(component)]
        if not is_loop(component, uses):
            ordered.append(first)
            continue
        names = [f"`{sheet.parameters[i].name.text}`" for i in sorted(component)]
        scope.report(
            "E209",
            f"parameter `{first.name.text}` depends on itself",
            first.name.position,
            "its default needs its own value" if len(names) == 1 else f"{', '.join(names)} need each other",
            "give one of them a value that does not need the others",
        )
        circular += [sheet.parameters[i].name.text for i in component]
    return ordered, circular


def _in_range(
    scope: Scope,
    quantity: Quantity,
    declaration: ParameterDeclaration,
    values: Mapping[str, Quantity],
    place: Position | None,
    source: str,
) -> bool:
    """Whether every element lies in the declared range; diagnosed (E208) if not.

    ``place``: where the value stands, or the sheet that inherits it is used; None if it comes from no sheet (``--set``).
    ``source``: a word about that for the diagnosis.
    """
    if declaration.range is None or quantity.text is not None:
        return True
    limits = scope.value_of(declaration.range, values)
    if limits is None:
        return False
    name, declared = declaration.name.text, declaration.range.position
    pair = np.ravel(np.asarray(limits.array, dtype=np.float64))
    if pair.size != 2:
        scope.report(
            "E208", f"the range of parameter `{name}` is no pair", declared, f"it has {pair.size} number{'' if pair.size == 1 else 's'}", "write range: [least, most]"
        )
        return False
    array = np.asarray(quantity.array, dtype=np.float64)
    outside = np.argwhere(~((array >= pair[0]) & (array <= pair[1])))
    if not len(outside):
        return True
    element = tuple(outside[0])
    which = f"element [{', '.join(map(str, element))}]" if element else "it"
    scope.report(
        "E208",
        f"parameter `{name}` is out of its range",
        place or declared,
        f"{which} is {float(array[element]):g}{source}, and must lie in {pair[0]:g} to {pair[1]:g}",
        "give a value inside the range",
        notes=[Note("its range is declared here", declared)] if place is not None else (),
    )
    return False


def _no_value(scope: Scope, sheet: Sheet, declaration: ParameterDeclaration, used: Position | None) -> None:
    name = declaration.name.text
    where = declaration.name.position if used is None else used
    if declaration.inherited:
        cause = "it is inherited from the sheet that uses this one"
        cause += ", and that sheet has no such parameter" if used is not None else ", and none does here"
        remedy = (
            f"declare `{name}` there"
            if used is not None
            else f"open the sheet that uses it, or give --set {name}=VALUE"
        )
    else:
        cause = "the sheet declares it without a default"
        remedy = f"give it: {{{sheet.name.text}: [...], {name}: 1}}" if used is not None else f"give --set {name}=VALUE"
    scope.report("E207", f"parameter `{name}` of `{sheet.name.text}` has no value", where, cause, remedy)


def _with_unit(
    scope: Scope, quantity: Quantity, declaration: ParameterDeclaration, position: Position
) -> Quantity | None:
    """The value in the declared unit: taken over if the value states none, checked if it does."""
    if declaration.unit is None or quantity.text is not None:
        return quantity
    from saoflow.diagrams.declarations import units_of

    units = units_of(scope, declaration.unit)
    if units is None:
        return None
    stated = quantity.unit
    if stated is None:
        return replace(quantity, unit=units)
    if stated != units and isinstance(stated, Unit) and isinstance(units, Unit):
        if stated.dimensionless:
            return replace(quantity, unit=units)
        scope.report(
            "E211",
            f"parameter `{declaration.name.text}` has another unit",
            position,
            f"{stated} is given, {units} is declared: {conversion_hint(stated, units)}",
            f"convert it with a factor in {units / stated}, or correct the unit that is wrong",
        )
        return None
    return quantity
