# SPDX-License-Identifier: Apache-2.0
"""The inputs of a model: terms as a user writes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Callable

from .errors import ModelError

KINDS = ("temperature", "gradient", "rate", "lag")
MOST_FACTORS = 3
LONGEST_TIME_CONSTANT_S = 86400


@dataclass(frozen=True)
class Factor:
    """One quantity of the thermometers: T, T − T, the causal dT/dt in °C/min, or a causal lag in K."""

    kind: str
    first: str
    second: str = ""  #: gradient only
    time_constant_s: int = 0  #: lag only

    @property
    def order(self) -> tuple[int, str, str, int]:
        return KINDS.index(self.kind), self.first, self.second, self.time_constant_s

    def __str__(self) -> str:
        return {"temperature": self.first, "gradient": f"{self.first}-{self.second}", "rate": f"rate:{self.first}",
                "lag": f"lag:{self.time_constant_s}:{self.first}"}[self.kind]


@dataclass(frozen=True)
class Term:
    """A product of one to three factors, in order.

    >>> str(parse_term("rate:A*A", ["A", "B"])), str(parse_term("A-B^2", ["A", "B"]))
    ('A*rate:A', 'A-B^2')
    """

    factors: tuple[Factor, ...]

    def __str__(self) -> str:
        groups = [(str(factor), len(list(same))) for factor, same in groupby(self.factors)]
        return "*".join(text if count == 1 else f"{text}^{count}" for text, count in groups)


def term_of(factors: Sequence[Factor]) -> Term:
    """The product of these factors."""
    if not 1 <= len(factors) <= MOST_FACTORS:
        raise ModelError(f"a term has one to three factors, not {len(factors)}")
    return Term(tuple(sorted(factors, key=lambda factor: factor.order)))


def term_from_json(entry: dict[str, Any]) -> Term:
    """A term as a model file has it."""
    factors = []
    for factor in entry["factors"]:
        if factor["kind"] not in KINDS:
            raise ModelError(f'an input is of a kind "{factor["kind"]}" that is not known')
        factors.append(Factor(factor["kind"], factor["first"], factor.get("second", ""),
                              int(factor.get("time_constant_s", 0))))
    return term_of(factors)


def _lag(text: str, names: Sequence[str], whole: str) -> Factor:
    seconds, colon, name = text.partition(":")
    if not colon or not seconds.isdecimal() or not 1 <= int(seconds) <= LONGEST_TIME_CONSTANT_S:
        raise ModelError(f'input "{whole}": a lag is lag:SECONDS:THERMOMETER, of 1 to {LONGEST_TIME_CONSTANT_S} whole'
                         " seconds")
    return Factor("lag", _known(name, names, whole), "", int(seconds))


def _known(name: str, names: Sequence[str], whole: str) -> str:
    if name not in names:
        raise ModelError(f'input "{whole}": no thermometer "{name}"; there are {", ".join(names) or "none"}')
    return name


def _factor(text: str, names: Sequence[str], whole: str) -> Factor:
    if text in names:
        return Factor("temperature", text)
    if text.startswith("lag:"):
        return _lag(text[len("lag:"):], names, whole)
    if text.startswith("rate:"):
        return Factor("rate", _known(text[len("rate:"):], names, whole))
    for at, letter in enumerate(text):  # a name may hold a '-'
        if letter == "-" and text[:at] in names and text[at + 1:] in names:
            if text[:at] == text[at + 1:]:
                raise ModelError(f'input "{whole}": a gradient needs two different thermometers')
            return Factor("gradient", text[:at], text[at + 1:])
    first, _, second = text.partition("-")
    raise ModelError(f'input "{whole}": no thermometer "{second if first in names else first}"; there are '
                     f"{', '.join(names) or 'none'}")


def _power(text: str, names: Sequence[str], whole: str) -> list[Factor]:
    try:
        return [_factor(text, names, whole)]
    except ModelError:
        if len(text) < 2 or text[-2] != "^":
            raise
    factor = _factor(text[:-2], names, whole)
    if text[-1] not in "23":
        raise ModelError(f'input "{whole}": a power is ^2 or ^3, not ^{text[-1]}')
    return [factor] * int(text[-1])


def _product(text: str, names: Sequence[str], whole: str) -> list[Factor]:
    try:
        return _power(text, names, whole)
    except ModelError as error:
        best = error
    for at, letter in enumerate(text):  # a name may hold a '*'
        if letter != "*":
            continue
        try:
            return _power(text[:at], names, whole) + _product(text[at + 1:], names, whole)
        except ModelError as error:
            if at == text.index("*"):
                best = error
    raise best


def parse_term(text: str, names: Sequence[str]) -> Term:
    """Reads "A", "A-B", "rate:A", "lag:600:A", "A^2", or a product of up to three like "A*rate:A".

    >>> parse_term("lag:600:A", ["A"]).factors[0].time_constant_s
    600
    """
    factors = _product(text, names, text)
    if len(factors) > MOST_FACTORS:
        raise ModelError(f'input "{text}": has more than {MOST_FACTORS} factors')
    return term_of(factors)


def evaluate(terms: Sequence[Term], value_of: Callable[[Factor], Any]) -> list[Any]:
    """The terms, from the values of their factors, multiplied in their order."""
    return [math.prod((value_of(factor) for factor in term.factors), start=1.0) for term in terms]
