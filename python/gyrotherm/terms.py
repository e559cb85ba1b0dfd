# SPDX-License-Identifier: Apache-2.0
"""Terms: the inputs of a model, in the notation of the option --inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Callable

from .errors import ModelError

KINDS = ("temperature", "gradient", "rate", "lag")
MAX_FACTORS = 3
MAX_TIME_CONSTANT_S = 86400


@dataclass(frozen=True)
class Factor:
    """A quantity of one or two thermometers: T in °C, T − T in K, the causal dT/dt in °C/min, or a causal lag in K."""

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
    """A product of one to three factors, sorted.

    >>> str(parse_term("rate:A*A", ["A", "B"])), str(parse_term("A-B^2", ["A", "B"]))
    ('A*rate:A', 'A-B^2')
    """

    factors: tuple[Factor, ...]

    def __str__(self) -> str:
        powers = [(str(factor), len(list(group))) for factor, group in groupby(self.factors)]
        return "*".join(text if exponent == 1 else f"{text}^{exponent}" for text, exponent in powers)


def make_term(factors: Sequence[Factor]) -> Term:
    """Returns the product of factors."""
    if not 1 <= len(factors) <= MAX_FACTORS:
        raise ModelError(f"a term has one to three factors, not {len(factors)}")
    return Term(tuple(sorted(factors, key=lambda factor: factor.order)))


def term_from_json(entry: dict[str, Any]) -> Term:
    """Returns the term of an entry of a model file."""
    factors = []
    for factor in entry["factors"]:
        if factor["kind"] not in KINDS:
            raise ModelError(f'an input has the unknown kind "{factor["kind"]}", expected {", ".join(KINDS)}')
        factors.append(Factor(factor["kind"], factor["first"], factor.get("second", ""),
                              int(factor.get("time_constant_s", 0))))
    return make_term(factors)


def _lag(text: str, names: Sequence[str], whole: str) -> Factor:
    seconds, colon, name = text.partition(":")
    if not colon or not seconds.isdecimal() or not 1 <= int(seconds) <= MAX_TIME_CONSTANT_S:
        raise ModelError(f'input "{whole}": expected lag:SECONDS:THERMOMETER with an integer from 1 to '
                         f"{MAX_TIME_CONSTANT_S}")
    return Factor("lag", _require_name(name, names, whole), "", int(seconds))


def _require_name(name: str, names: Sequence[str], whole: str) -> str:
    if name not in names:
        raise ModelError(f'input "{whole}": no thermometer "{name}", expected one of: {", ".join(names) or "none"}')
    return name


def _factor(text: str, names: Sequence[str], whole: str) -> Factor:
    if text in names:
        return Factor("temperature", text)
    if text.startswith("lag:"):
        return _lag(text[len("lag:"):], names, whole)
    if text.startswith("rate:"):
        return Factor("rate", _require_name(text[len("rate:"):], names, whole))
    for at, letter in enumerate(text):  # a name may contain '-'
        if letter == "-" and text[:at] in names and text[at + 1:] in names:
            if text[:at] == text[at + 1:]:
                raise ModelError(f'input "{whole}": a gradient needs two different thermometers')
            return Factor("gradient", text[:at], text[at + 1:])
    first, _, second = text.partition("-")
    raise ModelError(f'input "{whole}": no thermometer "{second if first in names else first}", expected one of: '
                     f"{', '.join(names) or 'none'}")


def _power(text: str, names: Sequence[str], whole: str) -> list[Factor]:
    try:
        return [_factor(text, names, whole)]
    except ModelError:
        if len(text) < 2 or text[-2] != "^":
            raise
    factor = _factor(text[:-2], names, whole)
    if text[-1] not in "23":
        raise ModelError(f'input "{whole}": expected ^2 or ^3, not ^{text[-1]}')
    return [factor] * int(text[-1])


def _product(text: str, names: Sequence[str], whole: str) -> list[Factor]:
    try:
        return _power(text, names, whole)
    except ModelError as error:
        first_error = error
    for at, letter in enumerate(text):  # a name may contain '*'
        if letter != "*":
            continue
        try:
            return _power(text[:at], names, whole) + _product(text[at + 1:], names, whole)
        except ModelError as error:
            if at == text.index("*"):
                first_error = error
    raise first_error


def parse_term(text: str, names: Sequence[str]) -> Term:
    """Parses "A", "A-B", "rate:A", "lag:600:A", "A^2", or a product of up to three factors such as "A*rate:A".

    >>> parse_term("lag:600:A", ["A"]).factors[0].time_constant_s
    600
    """
    factors = _product(text, names, text)
    if len(factors) > MAX_FACTORS:
        raise ModelError(f'input "{text}": has more than {MAX_FACTORS} factors')
    return make_term(factors)


def evaluate(terms: Sequence[Term], value_of: Callable[[Factor], Any]) -> list[Any]:
    """Returns the value of each term: the product of its factors' values, multiplied in order."""
    return [math.prod((value_of(factor) for factor in term.factors), start=1.0) for term in terms]
