"""Arguments and options that several commands have, and reading a mission as they say."""

from __future__ import annotations

from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mitlplan.cli_answers import say

if TYPE_CHECKING:
    from mitlplan.mission import Mission


class UntilChoice(str, Enum):
    """What until means."""

    standard = "standard"
    closed = "closed"


class HorizonChoice(str, Enum):
    """When the mission ends."""

    infinite = "infinite"
    finite = "finite"


class Construction(str, Enum):
    """How formulas become automata."""

    compact = "compact"
    seed = "seed"
    published = "published"


def _finite_option(seconds: float | None) -> float | None:
    if seconds is not None and not 0 < seconds < float("inf"):
        raise typer.BadParameter("a positive number of seconds is expected")
    return seconds


def exact_option(text: str | None) -> str | None:
    """A number that is not negative, written exactly; left as text."""
    from mitlplan.exact import exact

    if text is not None:
        try:
            exact(text)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
    return text


def positive_option(text: str | None) -> str | None:
    """A positive number, written exactly; left as text."""
    exact_option(text)
    if text is not None and Fraction(text) == 0:
        raise typer.BadParameter("a positive number is expected, such as 1/20")
    return text


MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help="A mission file, YAML or JSON.")]
ConstructionOption = Annotated[Construction, typer.Option(help="How formulas become automata.")]
Until = Annotated[UntilChoice | None, typer.Option(help="Instead of the mission's own.")]
Horizon = Annotated[HorizonChoice | None, typer.Option(help="Instead of the mission's own.")]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write here instead of to stdout.")
]
TimeLimit = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", callback=_finite_option, help="Stop so long after the start."),
]
MemoryLimit = Annotated[
    int | None, typer.Option(metavar="MB", min=1, help="Stop when the work holds so much.")
]


def read_mission(
    mission: Path,
    until: UntilChoice | None = None,
    horizon: HorizonChoice | None = None,
    epsilon: str | None = None,
) -> Mission:
    """The mission of a file, with what the command line says instead; its warnings go to stderr."""
    from mitlplan.mission import read

    found = read(
        mission,
        until=until.value if until else None,
        horizon=horizon.value if horizon else None,
        epsilon=Fraction(epsilon) if epsilon else None,
    )
    for warning in found.warnings:
        say(f"{mission}: warning: {warning}")
    return found
