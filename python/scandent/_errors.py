"""What can go wrong, by type."""

from __future__ import annotations

from typing import TYPE_CHECKING, Optional, Sequence

if TYPE_CHECKING:
    from ._plan import Plan


class Error(Exception):
    """What scandent raises; its own mistakes are this class itself."""


class InputError(Error, ValueError):
    """An input that cannot be used.

    ``argument`` is the name of the argument that is to blame, ``None`` where the words say it.
    """

    def __init__(self, words: str, argument: Optional[str] = None) -> None:
        blamed = argument is not None and argument not in words
        super().__init__(f"{argument}: {words}" if blamed else words)
        self.argument = argument


class Unsolved(Error):
    """A search without a verified plan.

    ``status`` says how it ended, ``reasons`` what blocks the way, nearest to the goal first, ``to_try``
    what may help, and ``partial`` is the way to the contact set nearest to the goal.
    """

    def __init__(
        self, words: str, status: str, reasons: Sequence[str], to_try: Sequence[str], partial: Plan
    ) -> None:
        super().__init__("; ".join([words, *reasons]))
        self.status = status
        self.reasons = list(reasons)
        self.to_try = list(to_try)
        self.partial = partial


class NoPlan(Unsolved):
    """There is no plan, and that is proved by lengths, weight or friction."""


class Undecided(Unsolved):
    """No plan was found and none is excluded: the budget is spent, everything was tried, or it was stopped."""


class Refused(Unsolved):
    """A plan was found, and the verifier refuses it."""
