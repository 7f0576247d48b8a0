"""Balls that touch each other: speed and overlap compared with Chipmunk and Box2D, growth, memory,
energy, and how the stepped solver's error falls with its step."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.contestants.common import AbsentError
from benchmarks.contestants.touching import CONTESTANTS, Chipmunk, Ours
from benchmarks.harness.clock import Job, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, length, spread
from benchmarks.scenes import touching as scenes
from benchmarks.scenes.contact_scenes import scene
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.multibody.scenes import GRAVITY_PRESETS, sandbox
from plinko.engine.parameters import Exact, Stepped
from plinko.engine.seeding import start_x

Maker = Callable[[], Any]
"""Makes a contestant's world of a heap, one for each run."""

MORE_STEPS = (4, 16, 64)
"""Steps per frame: our default number of substeps, and more, until Chipmunk's balls hardly
overlap."""

MODES = {"nobody sleeps": False, "who rests may sleep": True}


def run(effort: Effort) -> Section:
    section = Section("touching")
    _beside_others(section, effort)
    _with_more_steps(section, effort)
    _growth(section, effort)
    _pile(section, effort)
    _elastic(section, effort)
    _convergence(section, effort)
    return section


def _beside_others(section: Section, effort: Effort) -> None:
    n = effort.size(500, 60)
    frames = effort.size(600, 60)
    data: dict[str, Any] = {}
    for heap in (scenes.board(n), scenes.box(n)):
        for mode, sleeping in MODES.items():
            makers: dict[str, Maker] = {
                contestant.name: partial(contestant, heap, sleeping=sleeping)
                for contestant in CONTESTANTS
                if _is_there(contestant, heap, section)
            }
            title = f"{heap.name}, {mode}"
            data[title] = _versus(section, title, heap, makers, frames, effort)
    section.data["beside_others"] = data


def _with_more_steps(section: Section, effort: Effort) -> None:
    """Compare with Chipmunk at as many steps per frame as ours, and at more."""
    n = effort.size(500, 60)
    frames = effort.size(600, 60)
    data: dict[str, Any] = {}
    for heap in (scenes.board(n), scenes.box(n)):
        if not _is_there(Chipmunk, heap, section):
            return
        makers: dict[str, Maker] = {Ours.name: partial(Ours, heap, sleeping=False)}
        for steps in MORE_STEPS[: effort.size(len(MORE_STEPS), 1)]:
            name = f"Chipmunk, {steps} steps a frame"
            makers[name] = partial(Chipmunk, heap, sleeping=False, steps=steps)
        title = f"{heap.name}, Chipmunk with more steps"
        few = replace(effort, rounds=min(effort.rounds, 3))
        data[heap.name] = _versus(section, title, heap, makers, frames, few)
    section.data["more_steps"] = data


def _is_there(contestant: Any, heap: scenes.Heap, section: Section) -> bool:
    try:
        contestant(heap, sleeping=False).step()
    except AbsentError as error:
        if str(error) not in section.absent:
            section.absent.append(str(error))
        return False
    return True


def _run_job(maker: Maker, frames: int) -> Job:
    def job() -> float:
        world = maker()
        start = time.thread_time()
        for _ in range(frames):
            world.step()
        return time.thread_time() - start

    return job


def _watch(maker: Maker, heap: scenes.Heap, frames: int) -> tuple[float, int]:
    """In a separate run, the deepest overlap in radii after any frame, and the lost balls."""
    world = maker()
    worst = 0.0
    places = world.places()
    for _ in range(frames):
        world.step()
        places = world.places()
        worst = max(worst, scenes.overlap(heap, places[:, 0], places[:, 1]))
    return worst, scenes.lost(heap, places[:, 0], places[:, 1])


def _versus(
    section: Section, title: str, heap: scenes.Heap, makers: dict[str, Maker], frames: int,
    effort: Effort,
) -> dict[str, Any]:  # fmt: skip
    """Add a table of speed and overlap; returns the same figures as data."""
    jobs = {name: _run_job(maker, frames) for name, maker in makers.items()}
    times = in_turns(jobs, effort.rounds, lambda: effort.step(heap.name))
    seen = {name: _watch(maker, heap, frames) for name, maker in makers.items()}
    ours = times[Ours.name]
    rows = [
        [
            name,
            spread(sample.map(lambda s: frames / s), "{:,.0f}"),
            f"{sample.over(ours).median:.2f}",
            f"{100.0 * seen[name][0]:.2f} %",
            length(seen[name][0] * heap.radius),
            str(seen[name][1]),
        ]
        for name, sample in times.items()
    ]
    table = Table(
        title,
        ["engine", "frames/s", "time to ours", "deepest overlap, of the radius", "that is", "lost"],
        rows,
        [
            f"The first {frames} frames of 1/60 s, from the fall to the heap: processor seconds of "
            f"one core, median (smallest to largest) of {effort.rounds} round(s), engines in "
            "turns. Overlap after any frame, in a run that is not timed; lost: balls that went "
            "through a wall or the floor in it. Ours takes four substeps a frame."
        ],
    )
    section.tables.append(table)
    return {
        "seconds": {name: sample.to_dict() for name, sample in times.items()},
        "deepest_radii": {name: depth for name, (depth, _) in seen.items()},
        "lost": {name: lost for name, (_, lost) in seen.items()},
    }


def _growth(section: Section, effort: Effort) -> None:
    counts = (50, 160) if effort.quick else (50, 160, 500, 1600, 5000)
    frames = effort.size(60, 5)
    jobs: dict[str, Job] = {}
    for n in counts:
        jobs[str(n)] = _gas_job(n, frames)
    times = in_turns(jobs, effort.rounds, lambda: effort.step("growth"))
    per_ball = {n: times[str(n)].map(lambda s, n=n: 1e6 * s / (frames * n)) for n in counts}  # type: ignore[misc]
    slope = np.polyfit(np.log(counts), np.log([times[str(n)].median for n in counts]), 1)[0]
    memory = {n: _memory(n) for n in counts}
    section.tables.append(
        Table(
            "Cost and memory against the number of balls, at equal density",
            ["balls", "µs a frame", "µs a ball and frame", "bytes a ball"],
            [
                [
                    f"{n:,}",
                    spread(times[str(n)].map(lambda s: 1e6 * s / frames), "{:,.0f}"),
                    spread(per_ball[n], "{:.2f}"),
                    f"{memory[n]:.0f}",
                ]
                for n in counts
            ],
            [
                f"Elastic balls in a box that they fill to a seventh, in motion all the time. "
                f"Exponent of the time, by least squares: {slope:.3f}. Memory: all arrays that "
                "stay between frames, pairs and room to grow included."
            ],
        )
    )
    section.data["growth"] = {
        "count": list(counts),
        "seconds": [times[str(n)].to_dict() for n in counts],
        "exponent": float(slope),
        "bytes_per_ball": [memory[n] for n in counts],
    }


def _gas(n: int) -> Any:
    side = math.sqrt(n * math.pi * 0.05**2 * 7.0)
    return sandbox(
        n, restitution=1.0, friction=0.0, radii=(0.05, 0.05), width=side, height=side, speed=2.0,
        gravity=0.0,
    )  # fmt: skip


def _gas_job(n: int, frames: int) -> Job:
    arena = _gas(n)
    for _ in range(20):
        arena.step()

    def job() -> float:
        start = time.thread_time()
        for _ in range(frames):
            arena.step()
        return time.thread_time() - start

    return job


def _memory(n: int) -> float:
    arena = _gas(n)
    for _ in range(20):
        arena.step()
    return float(arena.nbytes) / n


def _pile(section: Section, effort: Effort) -> None:
    heap = scenes.box(effort.size(500, 60))
    arena = heap.arena(sleeping=True)
    asleep_at = None
    for k in range(3600):
        arena.step()
        if not arena.awake:
            asleep_at = (k + 1) * scenes.DT
            break
    rows: list[list[str]] = []
    if asleep_at is not None:
        empty = heap.arena(sleeping=True)
        empty.clear()
        times = in_turns(
            {"the sleeping pile": _steps(arena, 2000), "no balls at all": _steps(empty, 2000)},
            effort.rounds,
        )
        rows = [
            [name, spread(sample.map(lambda s: 1e6 * s / 2000), "{:.2f}")]
            for name, sample in times.items()
        ]
    section.tables.append(
        Table(
            f"A settled pile: {heap.name}",
            ["what", "µs a frame"],
            rows,
            [
                f"Asleep {asleep_at:.1f} s after the start."
                if asleep_at
                else "It never fell asleep."
            ],
        )
    )
    section.data["pile"] = {"asleep_after": asleep_at}


def _steps(arena: Any, count: int) -> Job:
    def job() -> float:
        start = time.thread_time()
        for _ in range(count):
            arena.step()
        return time.thread_time() - start

    return job


def _elastic(section: Section, effort: Effort) -> None:
    rows = []
    found = {}
    seconds = effort.size(60, 2)
    for gravity in ("none", "Earth"):
        arena = sandbox(
            effort.size(200, 40), gravity=GRAVITY_PRESETS[gravity], restitution=1.0, friction=0.0,
            radii=(0.08, 0.08), width=6.0, height=6.0, speed=3.0,
        )  # fmt: skip
        half = 0.5 * arena.settings.dt / arena.settings.substeps * arena.settings.gravity
        start = arena.diagnostics()
        drift = 0.0
        for _ in range(seconds * 60):
            arena.step()
            now = arena.diagnostics()
            change = now.total + half * now.py - start.total - half * start.py
            drift = max(drift, abs(change) / now.kinetic)
        effort.step("elastic")
        rows.append([gravity, f"{drift:.1e}"])
        found[gravity] = drift
    free = _free_momentum()
    section.tables.append(
        Table(
            f"An elastic box of equal balls over {seconds} s",
            ["gravity", "largest change of the energy, of the kinetic"],
            rows,
            [
                "With gravity the energy is that which semi-implicit Euler keeps, with g h v / 2 "
                "for the half substep by which its velocities lag. Momentum where nothing outside "
                f"acts (200 balls of all sizes, with friction, 5 s): changed by {free:.1e} of the "
                "sum of m |v|."
            ],
        )
    )
    section.data["elastic"] = found | {"momentum": free}


def _free_momentum() -> float:
    from plinko.engine import Arena, ArenaSettings, StaticGeometry

    arena = Arena(StaticGeometry(), ArenaSettings(gravity=0.0))
    rng = np.random.default_rng(2)
    i = np.arange(200)
    arena.add_many(
        0.3 * (i % 15), 0.3 * (i // 15), vx=rng.normal(0, 3, 200), vy=rng.normal(0, 3, 200),
        radius=rng.uniform(0.05, 0.14, 200), restitution=0.8, friction=0.4,
    )  # fmt: skip
    before = arena.diagnostics()
    mass = np.array([arena.ball(k)["mass"] for k in range(200)])
    bodies = arena.bodies
    scale = float((mass * np.hypot(bodies["vx"], bodies["vy"])).sum())
    for _ in range(300):
        arena.step()
    after = arena.diagnostics()
    return math.hypot(after.px - before.px, after.py - before.py) / scale


def _convergence(section: Section, effort: Effort) -> None:
    """Error of one ball just before its second impact, against the exact solver."""
    board = scene("low-restitution").board
    starts = [
        start_x(seed, board.drop.x, board.drop.jitter) for seed in range(effort.size(200, 10))
    ]
    substeps = (1, 2, 4, 8, 16, 32, 64, 128)
    medians = []
    for count in substeps:
        errors = []
        for x in starts:
            start = at_start(board, x)
            exact = follow(board, start, Exact())
            first, second = exact.events[0, 0], exact.events[1, 0]
            t = first + 0.9 * (second - first)
            truth = exact.states_at(np.array([t]))[0]
            state = follow(board, start, Stepped(1.0 / 60.0, count)).states_at(np.array([t]))[0]
            errors.append(math.hypot(state[1] - truth[1], state[2] - truth[2]))
        medians.append(float(np.median(errors)))
        effort.step("convergence")
    order = float(np.polyfit(np.log(substeps), np.log(medians), 1)[0])
    rows = []
    for k, (count, error) in enumerate(zip(substeps, medians, strict=True)):
        local = "" if k == 0 else f"{math.log2(medians[k - 1] / error):.2f}"
        rows.append([f"1/{60 * count} s", length(error), local])
    section.tables.append(
        Table(
            "One ball against the exact solver, before its second impact",
            ["substep", "median error", "order from the row above"],
            rows,
            [f"{len(starts)} drops; order by least squares {-order:.2f}."],
        )
    )
    section.data["convergence"] = {
        "h": [1.0 / (60.0 * count) for count in substeps],
        "error": medians,
        "order": -order,
    }
    section.plots["bench-convergence.png"] = lambda path: _plot(section.data["convergence"], path)


def _plot(data: dict[str, Any], path: str) -> None:
    from benchmarks.harness import plots

    figure, (axis,) = plots.start(5.2, 3.4)
    h, error = np.array(data["h"]), np.array(data["error"])
    axis.loglog(h, error[0] * h / h[0], color=plots.FAINT, linewidth=1.0)
    axis.loglog(h, error, "o-", color=plots.STEPPED, markersize=4)
    axis.set_xlabel("substep, s")
    axis.set_ylabel("median error, m")
    axis.set_title("Error before the second impact; grey: order 1", pad=10)
    plots.finish(figure, path)
