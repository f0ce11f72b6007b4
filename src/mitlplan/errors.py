"""Every error a user can meet.

Each carries one sentence that says what is wrong, where, and how to mend it. The command line prints the
sentence and exits with 2; nothing else in the project prints or exits.
"""

from __future__ import annotations

_LONGEST = 1000


class MitlplanError(Exception):
    """The common parent: ``str(error)`` is the sentence for the user."""


class OutOfTime(BaseException):  # like KeyboardInterrupt: no error, and not to be swallowed
    """A time limit is over: raised between stages, and by the command line's alarm at any moment.

    Whoever has found something by then hands it out.
    """


def _readable(message: str) -> str:
    """The message without its middle, if that is a name of megabytes."""
    half = _LONGEST // 2
    return message if len(message) <= _LONGEST else f"{message[:half]} ... {message[-half:]}"


class FormulaError(MitlplanError):
    """A formula that cannot be read; the message shows the text with a caret under the place.

    Parameters
    ----------
    problem
        One sentence: what is wrong and what was expected.
    text
        The formula.
    position, length
        Where in `text`, in characters.
    hint
        What to write instead, or the empty string.
    """

    def __init__(self, problem: str, text: str, position: int, *, length: int = 1, hint: str = "") -> None:
        self.problem = problem
        self.text = text
        self.position = position
        self.length = length
        self.hint = hint
        super().__init__(self._render())

    def _render(self) -> str:
        if not self.text.strip():
            return self.problem
        # A long formula is shown by the piece around the caret, so the caret stays visible.
        start = max(0, self.position - 60)
        end = min(len(self.text), self.position + 60)
        before = "..." if start > 0 else ""
        after = "..." if end < len(self.text) else ""
        # One sign a column: what would move the caret, or the terminal's cursor, is shown as a space.
        shown = before + "".join(sign if sign.isprintable() else " " for sign in self.text[start:end]) + after
        caret = " " * (len(before) + self.position - start) + "^" * max(
            1, min(self.length, end - self.position)
        )
        lines = [self.problem, f"  {shown}", f"  {caret}"]
        if self.hint:
            lines.append(f"  hint: {self.hint}")
        return "\n".join(lines)


class MissionError(MitlplanError):
    """A mission file that cannot be used; the message begins with file, line and column."""

    def __init__(
        self, problem: str, *, file: str = "", line: int | None = None, column: int | None = None
    ) -> None:
        self.problem = problem
        self.file = file
        self.line = line
        self.column = column
        place = ":".join(str(part) for part in (file, line, column) if part not in ("", None))
        super().__init__(_readable(f"{place}: {problem}" if place else problem))


class WorkspaceError(MitlplanError):
    """A workspace that makes no sense: an unknown cell, a negative time, a map that cannot be read.

    `where` is the path of keys and places at which it was given, such as ``("regions", "A", 0)``.
    """

    def __init__(self, problem: str, *, where: tuple[str | int, ...] = ()) -> None:
        self.where = where
        super().__init__(problem)


class OutputError(MitlplanError):
    """A file that cannot be written."""


class PlanFileError(MitlplanError):
    """A plan file that cannot be read, or that does not belong to the mission."""


class TranslationError(MitlplanError):
    """A formula that no automaton of the chosen construction can express."""


class TrajectoryError(MitlplanError):
    """A plan that the robot cannot drive: the message names the cell and the limit."""


class ModelError(MitlplanError):
    """A model of another tool that cannot be read; the message begins with file, line and element."""

    def __init__(self, problem: str, *, file: str = "", line: int | None = None, element: str = "") -> None:
        self.problem = problem
        self.file = file
        self.line = line
        self.element = element
        place = ":".join(str(part) for part in (file, line) if part not in ("", None))
        super().__init__(_readable(": ".join(part for part in (place, element, problem) if part)))


class ToolError(MitlplanError):
    """Another tool that is not there, or did not answer as expected; the message says how to get it."""
