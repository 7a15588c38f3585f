"""What a film of an operation shows when: every solved frame, held where a step is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lappet.plates.plate_steps import PlateStep, StepKind


@dataclass(frozen=True)
class FilmFrame:
    """A picture of a film.

    Parameters
    ----------
    step
        The frame and what it shows; `StepKind.FRAME` on the way to a step.
    seconds
        How long it is shown.
    caption
        The step whose caption stands below it: that which it shows, or that which it is on the way to.
    """

    step: PlateStep
    seconds: float
    caption: PlateStep


def film_frames(
    times: Sequence[float], steps: Sequence[PlateStep], fps: float, pause: float, turning: bool = False
) -> list[FilmFrame]:
    """List the pictures of a film.

    Parameters
    ----------
    times
        Time codes of the solved frames, ascending.
    steps
        The steps of the operation, ascending.
    fps
        Solved frames per second on the way from step to step.
    pause
        Seconds for which each step is held.
    turning
        Whether the camera goes on turning while a step is held, which is as many pictures then as on the way.

    Returns
    -------
    list[FilmFrame]
        The pictures from the first step to the last, in order.
    """
    told = {step.time: step for step in steps}
    found = []
    for time in times:
        if not steps[0].time <= time <= steps[-1].time:
            continue
        if time in told:
            count = max(round(pause * fps), 1) if turning else 1
            found += [FilmFrame(told[time], pause / count, told[time])] * count
        else:
            coming = next(step for step in steps if step.time > time)
            found.append(FilmFrame(PlateStep(time, StepKind.FRAME), 1.0 / fps, coming))
    return found


def chapters(frames: Sequence[FilmFrame]) -> list[tuple[float, float, PlateStep]]:
    """Divide a film into chapters, one for each step: the way to it, and the pause on it.

    Parameters
    ----------
    frames
        The pictures of the film.

    Returns
    -------
    list[tuple[float, float, PlateStep]]
        Begin and end of each in seconds, and its step.
    """
    found: list[tuple[float, float, PlateStep]] = []
    now = 0.0
    for frame in frames:
        begin = found[-1][0] if found and found[-1][2] == frame.caption else now
        if begin != now:
            found.pop()
        now += frame.seconds
        found.append((begin, now, frame.caption))
    return found
