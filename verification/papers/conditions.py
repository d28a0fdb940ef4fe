"""A claim under several choices of what a paper leaves open: where it holds, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

from verification.papers.finding import Verdict


@dataclass(frozen=True)
class Factor:
    """One open choice: its options, as they read after "holds only if"."""

    options: tuple[str, ...]


def judged(factors: Sequence[Factor], claim: Callable[..., bool]) -> tuple[Verdict, str]:
    """Try a claim under every combination of options (by index, one argument a factor).

    Returns the verdict and its condition: it holds under all, under none, or under those that are named. A factor that
    decides nothing is left out.
    """
    choices = [range(len(factor.options)) for factor in factors]
    held = {choice for choice in product(*choices) if claim(*choice)}
    if not held:
        return Verdict.FAILS, ""
    if len(held) == len(list(product(*choices))):
        return Verdict.HOLDS, ""
    decisive = [i for i in range(len(factors)) if not _indifferent(held, i, choices[i])]
    kept = sorted({tuple(choice[i] for i in decisive) for choice in held})
    phrases = [" and ".join(factors[i].options[o] for i, o in zip(decisive, one, strict=True)) for one in kept]
    return Verdict.ONLY_IF, "; or if ".join(phrases)


def _indifferent(held: set[tuple[int, ...]], i: int, options: Sequence[int]) -> bool:
    """Whether changing option ``i`` never changes the outcome."""
    return all((*choice[:i], option, *choice[i + 1 :]) in held for choice in held for option in options)
