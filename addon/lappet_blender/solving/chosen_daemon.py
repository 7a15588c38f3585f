"""The daemon that the preferences name, in place of one that is started here, and what it says of itself.

It may be far away, so a thread asks it; the main thread waits a moment at most.
"""

from __future__ import annotations

import threading

import bpy

from lappet.core.problem import Problem, ProblemsError, RefusedError, file_problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.running_daemon import RunningDaemon

ADDON = (__package__ or "").rpartition(".")[0]
_SILENCE = 5.0  # seconds until a daemon counts as absent
_MOMENT = 0.4  # seconds that the window may wait


class _Answer:
    """What one daemon said, as soon as it is `done`: who it is, or why that is not known."""

    def __init__(self, daemon: RunningDaemon) -> None:
        self.identity = ""
        self.problems: tuple[Problem, ...] = ()
        self.thread = threading.Thread(target=self._ask, args=(daemon,), name="lappet daemon", daemon=True)
        self.thread.start()

    def _ask(self, daemon: RunningDaemon) -> None:
        try:
            from lappet.daemon.daemon_solver import solver_identity

            self.identity = solver_identity(daemon, _SILENCE)
        except ProblemsError as error:
            self.problems = error.problems
        except OSError as error:
            self.problems = (file_problem(error),)
        except Exception as error:
            self.problems = (problem(ProblemCode.INTERNAL, "", f"{type(error).__name__}: {error}"),)

    @property
    def done(self) -> bool:
        return not self.thread.is_alive()


_answers: dict[RunningDaemon, _Answer] = {}


def chosen_daemon() -> RunningDaemon | None:
    """The daemon of the preferences; None where they name none."""
    entry = bpy.context.preferences.addons.get(ADDON)
    preferences = None if entry is None else entry.preferences
    if preferences is None or not preferences.daemon.strip():
        return None
    return RunningDaemon(*(each.strip() for each in (preferences.daemon, preferences.server_key, preferences.key)))


def identity_of(daemon: RunningDaemon) -> str:
    """What identifies the daemon in keys; raises RefusedError where that is not known, or not yet."""
    answer = _answers.get(daemon)
    if answer is None:
        answer = _answers[daemon] = _Answer(daemon)
    answer.thread.join(2.0 * _SILENCE if bpy.app.background else _MOMENT)
    if not answer.done:
        raise RefusedError.of(ProblemCode.DAEMON_ASKED, "", daemon.address)
    if answer.problems:
        raise RefusedError(answer.problems)
    return answer.identity


def ask_again() -> None:
    """Have daemons that could not be reached asked anew when they are next needed."""
    for daemon, answer in list(_answers.items()):
        if answer.done and answer.problems:
            del _answers[daemon]


def answer_state() -> tuple[object, ...]:
    """What changes when another daemon is chosen, and when the chosen one has answered."""
    daemon = chosen_daemon()
    answer = None if daemon is None else _answers.get(daemon)
    return daemon, answer is not None and answer.done, "" if answer is None else answer.identity


def said() -> str:
    """A sentence about the chosen daemon for the preferences."""
    daemon = chosen_daemon()
    if daemon is None:
        return "A daemon is started on this computer whenever one is needed."
    answer = _answers.get(daemon)
    if answer is None or not answer.done:
        return f"The daemon at {daemon.address} has not been asked yet." if answer is None else "It is being asked."
    return " ".join(map(str, answer.problems)) or f"It answers: Lappet {answer.identity.split()[-1]}."
