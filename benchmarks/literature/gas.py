"""Elastic discs by this engine and by event-driven molecular dynamics: cost of an impact, and
whether both find the same motion."""

import time
from typing import Any

import numpy as np

from benchmarks.contestants.common import AbsentError
from benchmarks.contestants.event_driven import CONTESTANTS, Ours
from benchmarks.harness.clock import Job, Sample, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, length, spread
from benchmarks.scenes.touching import DT, Gas, gas

FRAMES = {"this engine": 600, "billiards (PyPI)": 3}
"""Frames of 1/60 s that are timed: with 500 balls one engine is fast, the other takes seconds per
frame."""

LOOKS = (3, 6, 12)
"""Frames after which both are compared; later, chaos separates them in any case."""


def cost_of_an_impact(section: Section, effort: Effort) -> None:
    """Add a table of the cost of each installed engine, and a table of the balls' distances."""
    scene = gas(effort.size(500, 40))
    makers = _those_there(scene, section)
    rounds = min(effort.rounds, 3)
    jobs = {
        name: _job(maker, scene, effort.size(FRAMES[name], 3)) for name, maker in makers.items()
    }
    times = in_turns(jobs, rounds, lambda: effort.step("gas"))
    section.tables.append(_cost_table(scene, times, rounds))
    section.data["gas"] = {
        "seconds_per_impact": {name: sample.to_dict() for name, sample in times.items()},
        "apart": _apart(section, scene, makers, effort),
    }


def _those_there(scene: Gas, section: Section) -> dict[str, Any]:
    found = {}
    for maker in CONTESTANTS:
        try:
            maker(gas(2))
        except AbsentError as error:
            section.absent.append(str(error))
            continue
        found[maker.name] = maker
    return found


def _job(maker: Any, scene: Gas, frames: int) -> Job:
    """Processor seconds per impact of a new run, without building the scene."""

    def job() -> float:
        world = maker(scene)
        start = time.thread_time()
        world.run(frames * DT)
        seconds = time.thread_time() - start
        return float(seconds / world.impacts())

    return job


def _cost_table(scene: Gas, times: dict[str, Sample], rounds: int) -> Table:
    return Table(
        f"Cost of an impact: {scene.heap.name}, no gravity",
        ["engine", "µs an impact", "time to ours"],
        [
            [
                name,
                spread(sample.map(lambda s: 1e6 * s), "{:,.2f}"),
                f"{sample.over(times[Ours.name]).median:,.1f}",
            ]
            for name, sample in times.items()
        ],
        [
            "The balls and box of the benchmark `touching`, elastic, each at 2 m/s: all that "
            "event-driven molecular dynamics knows; it has no gravity, friction or rest. Processor "
            f"seconds of one core over impacts, median (smallest to largest) of {rounds} round(s); "
            "ours counts its steps and substeps, which such codes do not have."
        ],
    )


def _apart(
    section: Section, scene: Gas, makers: dict[str, Any], effort: Effort
) -> list[dict[str, float]]:
    """Add a table of the largest distance between the balls of both engines, by time."""
    if len(makers) < 2:
        return []
    ours, other = (maker(scene) for maker in makers.values())
    found: list[dict[str, float]] = []
    done = 0
    for frames in LOOKS[: effort.size(len(LOOKS), 1)]:
        for world in (ours, other):
            world.run((frames - done) * DT)
        done = frames
        found.append(
            {
                "frames": frames,
                "impacts": ours.impacts(),
                "others_impacts": other.impacts(),
                "apart": float(np.abs(ours.places() - other.places()).max()),
            }
        )
        effort.step("gas")
    names = list(makers)
    section.tables.append(
        Table(
            f"The same motion by two codes: {scene.heap.name}, no gravity",
            ["after", f"impacts, {names[0]}", f"impacts, {names[1]}", "farthest apart"],
            [
                [
                    f"{look['frames']:.0f}/60 s",
                    f"{look['impacts']:.0f}",
                    f"{look['others_impacts']:.0f}",
                    length(look["apart"]),
                ]
                for look in found
            ],
            ["Largest difference of a coordinate of any ball; each impact multiplies it."],
        )
    )
    return found
