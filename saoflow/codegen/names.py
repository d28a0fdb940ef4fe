"""All C names, made in one place: whatever a sheet calls things, names neither collide nor escape.

A name keeps what is legible of the sheet's own (ASCII letters, digits, underscores) and is made unique with a number.
No name begins with an underscore, is a keyword or a macro of a standard header, or is longer than 31 characters (what
C99 guarantees for external names).
"""

from __future__ import annotations

import re

from saoflow.codegen.macros import is_macro

KEYWORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "bool",
        "true",
        "false",
        "asm",
        "typeof",
        "alignas",
        "alignof",
        "atomic",
        "complex",
        "imaginary",
        "generic",
        "noreturn",
        "static_assert",
        "thread_local",
        "nullptr",
        "constexpr",
        "main",
        "NULL",
        "linux",
        "unix",
        "i386",
        "near",
        "far",
        "interrupt",
        "errno",
        "and",
        "or",
        "not",
        "xor",
        "bitand",
        "bitor",
        "compl",
        "not_eq",
        "and_eq",
        "or_eq",
        "xor_eq",
        "class",
        "new",
        "delete",
        "this",
        "template",
        "typename",
        "namespace",
        "using",
        "public",
        "private",
        "protected",
        "virtual",
        "friend",
        "operator",
        "try",
        "catch",
        "throw",
        "mutable",
        "explicit",
        "export",
        "const_cast",
        "dynamic_cast",
        "reinterpret_cast",
        "static_cast",
        "typeid",
        "wchar_t",
        "char8_t",
        "char16_t",
        "char32_t",
        "concept",
        "requires",
        "co_await",
        "co_return",
        "co_yield",
        "consteval",
        "constinit",
        "decltype",
        "noexcept",
    ]
)
"""Words of C (and C++, for headers), and macros that some compilers define."""

LONGEST = 31


def legible(text: str, most: int = LONGEST) -> str:
    """What of a text can stand in a C name; perhaps nothing."""
    kept = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    if kept[:1].isdigit():
        kept = f"n{kept}"
    return kept[:most].rstrip("_")


class Names:
    """One scope of C names: the file, or the fields of a struct."""

    def __init__(self, reserved: frozenset[str] = frozenset()) -> None:
        self._taken = set(KEYWORDS | reserved)

    def make(self, text: str, fallback: str, most: int = LONGEST) -> str:
        """A fresh name for ``text``; ``fallback`` serves where nothing of it is legible."""
        base = legible(text, most) or fallback
        name, number = base, 1
        while name in self._taken or name.lower() in self._taken or is_macro(name):
            number += 1
            suffix = f"_{number}"
            name = base[: most - len(suffix)].rstrip("_") + suffix
        self._taken.add(name)
        self._taken.add(name.lower())
        return name
