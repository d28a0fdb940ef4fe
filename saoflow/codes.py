"""The registry of all diagnosis codes: stable numbers, one line each.

E1xx reading text; E2xx elaboration (names, parameters, shapes, types, units, profiles); E3xx order and lowering;
E4xx budgets; E5xx recordings and runs; E6xx commands and files.
"""

from __future__ import annotations

CODES: dict[str, str] = {
    # reading
    "E101": "the file cannot be read",
    "E102": "the file is not YAML",
    "E103": "the file is empty",
    "E104": "the file is not text",
    "E105": "duplicate key",
    "E106": "unknown key",
    "E107": "a required key is missing",
    "E108": "a value has the wrong kind",
    "E109": "aliases or nesting exceed the bound",
    "E110": "the file exceeds the size bound",
    "E111": "an expression cannot be parsed",
    "E112": "a name is not valid",
    "E113": "a unit cannot be parsed",
    "E114": "a YAML tag or document marker that sheets do not use",
    # elaboration
    "E201": "unknown symbol or sheet",
    "E202": "unknown wire",
    "E203": "unknown port",
    "E204": "shapes do not fit",
    "E205": "unconnected input",
    "E206": "unknown parameter",
    "E207": "a parameter has no value",
    "E208": "a parameter value is out of its domain",
    "E209": "a parameter expression cannot be evaluated",
    "E210": "a real wire where a boolean is needed, or the reverse",
    "E211": "units do not fit",
    "E212": "the profile does not allow the symbol",
    "E213": "sheets use each other in a circle",
    "E214": "table breakpoints do not increase",
    "E215": "table data do not fit",
    "E216": "a count is not a whole number in range",
    "E217": "an index is out of range",
    "E218": "an operand cannot be wired so",
    "E219": "the elaborated sheet exceeds the size bound",
    "E220": "a delay's shape or unit does not match its input",
    "E221": "wrong number of operands",
    "E222": "a name is used twice",
    "E223": "the table's error bound cannot be proved",
    # order and lowering
    "E301": "algebraic loop",
    "E302": "the schedule fails its independent check",
    "E303": "unknown probe",
    # budget
    "E401": "over budget",
    # recordings and runs
    "E501": "the recording cannot be read",
    "E502": "a column is missing",
    "E503": "not a number",
    "E504": "the recording has no rows",
    "E505": "rows of different length",
    "E506": "duplicate column",
    "E507": "an input array has the wrong shape",
    "E508": "the sheet's state does not match",
    "W501": "missing samples in the recording",
    # commands and files
    "E601": "the output cannot be written",
    "E602": "no such sheet",
    "E603": "an option's value is not valid",
    "E604": "no reference for the sheet",
    "E605": "an optional package is not installed",
    "E607": "the backend is not available",
    "E608": "no such target",
    "E609": "the command line cannot be understood",
    "E610": "the sheet is too large for the stack",
    "W607": "another backend or cache than asked for, or sources without a binary",
    "E699": "an error inside saoflow",
}
