"""The cost of pictures: frames of a live room, drops as stills and animations, a live stream."""

import asyncio
import io
import time
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from benchmarks.harness.clock import Job, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving import drawing
from plinko.engine import Board, Drop, World, drop, drop_many

BOARD: Final = "triangle-16"
WIDTH: Final = 760  # px, the reference game's canvas
BALLS: Final = 50
FRAMES_A_SECOND: Final = 1000.0
PNG_SECONDS: Final = 5e-3
GIF_LENGTH, GIF_FPS = 4.0, 30  # s, frames/s
GIF_SECONDS, GIF_BYTES = 0.5, 1_000_000
BAND: Final = 2.0
"""Allowed error of the mean of 8 x 8 pixels, in levels of 255. A smooth gradient with 8 bits per
channel has steps of one level anyway, and a step of two is barely visible."""

VIEWERS: Final = (1, 50)


def run(effort: Effort) -> Section:
    section = Section("pictures")
    _frames(section, effort)
    _drops(section, effort)
    _many(section, effort)
    _stream(section, effort)
    drawing.ticks(section, effort)
    return section


def _repeated(work: Callable[[], object], times: int) -> Job:
    """A job that returns the mean processor seconds of several calls in a row."""

    def repeat() -> None:
        for _ in range(times):  # each result is freed at once, as in a server
            work()

    return lambda: seconds_of(repeat, time.process_time) / times


def _kept(name: str, draw: Callable[[], bytes], made: dict[str, bytes]) -> Job:
    """A job that returns the processor seconds of one call, and stores the picture in `made`."""

    def keep() -> None:
        made[name] = draw()

    return lambda: seconds_of(keep, time.process_time)


def _crowd() -> World:
    """A world with BALLS balls spread over the board."""
    world = World(Board.preset(BOARD))
    seed = 0
    while world.count < BALLS:
        world.add(seed)
        seed += 1
        for _ in range(5):
            world.step()
    return world


def _trails(world: World) -> dict[int, npt.NDArray[np.float64]]:
    """By ball, its positions in the last five frames at 30 per second, newest first."""
    past: list[dict[int, tuple[float, float]]] = []
    for _ in range(5):
        world.step()
        world.step()
        past.insert(0, {int(b["id"]): (float(b["x"]), float(b["y"])) for b in world.bodies})
    return {
        number: np.array([places[number] for places in past if number in places])
        for number in past[0]
    }


def _frames(section: Section, effort: Effort) -> None:
    """A frame with the cached board layer, and the cost of encoding it."""
    from plinko.app.render import Stage

    world = _crowd()
    stage = Stage(world.board, WIDTH)
    bodies = world.bodies
    moved = _crowd()
    trails, later = _trails(moved), moved.bodies
    pixels = stage.frame(bodies)
    picture = Image.fromarray(pixels)
    sizes = {
        "PNG, palette of the stage": len(stage.png(pixels)),
        "JPEG": len(stage.jpg(pixels)),
        "PNG by Pillow, compress_level 1": len(_pillow_png(picture)),
    }
    times = effort.size(50, 3)
    jobs: dict[str, Job] = {
        "frame": _repeated(lambda: stage.frame(bodies), times),
        "frame with trails": _repeated(lambda: stage.frame(later, trails=trails), times),
        "frame, nothing cached": _repeated(lambda: _anew(world), 1),
        "PNG, palette of the stage": _repeated(lambda: stage.png(pixels), times),
        "JPEG": _repeated(lambda: stage.jpg(pixels), times),
        "PNG by Pillow, compress_level 1": _repeated(lambda: _pillow_png(picture), 3),
    }
    found = in_turns(jobs, effort.rounds, lambda: effort.step("frames"))
    verdicts = {
        "frame": _verdict(1.0 / found["frame"].median >= FRAMES_A_SECOND),
        "PNG, palette of the stage": _verdict(
            found["PNG, palette of the stage"].median <= PNG_SECONDS
        ),
    }
    section.data["frames"] = {name: sample.to_dict() for name, sample in found.items()}
    section.data["bytes"] = sizes
    section.tables.append(
        Table(
            f"A frame of {stage.view.width} x {stage.view.height} pixels with {BALLS} balls",
            ["what", "ms", "a second", "bytes", ""],
            [
                [
                    name,
                    spread(sample.map(lambda s: 1e3 * s), "{:.2f}"),
                    f"{1.0 / sample.median:,.0f}",
                    f"{sizes[name]:,}" if name in sizes else "",
                    verdicts.get(name, ""),
                ]
                for name, sample in found.items()
            ],
            [
                f"{BOARD}, processor time of one thread. Aims: {FRAMES_A_SECOND:,.0f} frames a "
                f"second on the cached layer, {1e3 * PNG_SECONDS:g} ms for a PNG."
            ],
        )
    )


def _anew(world: World) -> object:
    """A frame with nothing cached: the board is painted too."""
    from plinko.app.render import Stage
    from plinko.app.render.parts.board import board_pixels

    board_pixels.cache_clear()
    return Stage(world.board, WIDTH).frame(world.bodies)


def _pillow_png(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", compress_level=1)
    return buffer.getvalue()


def four_seconds() -> Drop:
    """The drop among a thousand per board whose duration is nearest to GIF_LENGTH."""
    boards = [Board.preset(f"triangle-{rows}") for rows in (16, 12, 8)]
    found = [
        (abs(float(duration) - GIF_LENGTH), number, seed)
        for number, board in enumerate(boards)
        for seed, duration in enumerate(drop_many(board, range(1000)).duration)
    ]
    _, number, seed = min(found)
    return drop(boards[number], seed)


def _drops(section: Section, effort: Effort) -> None:
    """A drop of four seconds in every format."""
    from plinko.app.render import drop_animation, drop_picture

    d, fps = four_seconds(), effort.size(GIF_FPS, 5)
    drawings: dict[str, Callable[[], bytes]] = {
        "PNG": lambda: drop_picture(d),
        "JPEG": lambda: drop_picture(d, "jpg"),
        "GIF": lambda: drop_animation(d, "gif", fps=fps),
        "APNG": lambda: drop_animation(d, "apng", fps=fps),
        "WebP": lambda: drop_animation(d, "webp", fps=fps),
    }
    made: dict[str, bytes] = {}
    jobs = {name: _kept(name, draw, made) for name, draw in drawings.items()}
    found = in_turns(jobs, effort.rounds, lambda: effort.step("drops"))
    sizes = {name: len(data) for name, data in made.items()}
    off = {name: bands(d, made[name], fps) for name in ("GIF", "APNG", "WebP")}
    good = found["GIF"].median <= GIF_SECONDS and sizes["GIF"] <= GIF_BYTES and off["GIF"] <= BAND
    section.data["drops"] = {name: sample.to_dict() for name, sample in found.items()}
    section.data["drop_bytes"] = sizes
    section.data["bands"] = off
    section.tables.append(
        Table(
            f"A drop of {d.duration:.2f} s, 760 pixels wide",
            ["format", "s", "bytes", "squares off by", ""],
            [
                [
                    name,
                    spread(sample, "{:.3f}"),
                    f"{sizes[name]:,}",
                    f"{off[name]:.2f}" if name in off else "",
                    _verdict(good) if name == "GIF" else "",
                ]
                for name, sample in found.items()
            ],
            [
                f"{d.board.name}, seed {d.seed}; processor time of one call, animations at "
                f"{fps} frames/s. The fourth column says how visible bands are: over all "
                "squares of 8 x 8 pixels of every tenth frame, 99 % have a mean that is off by "
                "no more than that many levels of 255 from the frame before encoding. Aims of "
                f"the GIF: {GIF_SECONDS:g} s, {GIF_BYTES:,} bytes, {BAND:g} levels."
            ],
        )
    )


def bands(d: Drop, animation: bytes, fps: int) -> float:
    """The 99th percentile of the error of the means of 8 x 8 pixels, in levels of 255."""
    from plinko.app.render.animation import Film
    from plinko.app.render.still import DEFAULT_WIDTH

    meant = Film(d, DEFAULT_WIDTH, fps, "light")
    frame, off = meant.first(), []
    with Image.open(io.BytesIO(animation)) as shown:
        for number, (left, top, pixels) in enumerate(meant.patches(), 1):
            height, width = pixels.shape[:2]
            frame[top : top + height, left : left + width] = pixels
            if number % 10 == 0:
                shown.seek(number)
                seen = np.asarray(shown.convert("RGB"))
                off.append(abs(_squares(seen) - _squares(frame)))
    return float(np.quantile(np.concatenate(off), 0.99))


def _squares(pixels: npt.NDArray[np.uint8]) -> npt.NDArray[np.float64]:
    """Means over squares of 8 x 8 pixels, one number per channel."""
    height, width = (8 * (size // 8) for size in pixels.shape[:2])
    tiles = pixels[:height, :width].reshape(height // 8, 8, width // 8, 8, 3)
    means: npt.NDArray[np.float64] = tiles.mean(axis=(1, 3), dtype=np.float64).ravel()
    return means


def _many(section: Section, effort: Effort) -> None:
    """Pictures of many drops."""
    from plinko.app.render import contact_sheet, density_picture, histogram_picture

    board = Board.preset(BOARD)
    drops, tiles = effort.size(100_000, 200), effort.size(25, 4)
    counts = drop_many(board, range(1000)).histogram
    drawings: dict[str, Callable[[], bytes]] = {
        f"sheet of {tiles} drops": lambda: contact_sheet(board, range(tiles)),
        f"density of {drops:,} drops": lambda: density_picture(board, range(drops), threads=1),
        "histogram, drops counted before": lambda: histogram_picture(board, counts),
    }
    made: dict[str, bytes] = {}
    jobs = {name: _kept(name, draw, made) for name, draw in drawings.items()}
    rounds = min(effort.rounds, 3)
    found = in_turns(jobs, rounds, lambda: effort.step("many drops"))
    sizes = {name: len(data) for name, data in made.items()}
    section.data["many"] = {name: sample.to_dict() for name, sample in found.items()}
    section.tables.append(
        Table(
            "Pictures of many drops",
            ["what", "s", "bytes"],
            [
                [name, spread(sample, "{:.3f}"), f"{sizes[name]:,}"]
                for name, sample in found.items()
            ],
            [f"{BOARD}; processor time, the drops included, PNG."],
        )
    )


def _stream(section: Section, effort: Effort) -> None:
    """A live stream of a room with no viewer, one, and fifty."""
    ticks = effort.size(240, 6)
    drawn: dict[str, float] = {}

    def job(name: str, viewers: int) -> Job:
        def film() -> float:
            made = asyncio.run(_filmed(viewers, ticks))
            drawn[name] = made["drawn"]
            return float(made["cpu"])

        return film

    watchers = {"nobody": 0, **{f"{n} viewer{'s' * (n > 1)}": n for n in VIEWERS}}
    jobs = {name: job(name, viewers) for name, viewers in watchers.items()}
    found = in_turns(jobs, effort.rounds, lambda: effort.step("stream"))
    base = found["nobody"]
    section.data["stream"] = {name: sample.to_dict() for name, sample in found.items()}
    section.data["stream_frames"] = drawn
    section.tables.append(
        Table(
            f"A room with {BALLS} balls, filmed",
            ["for", "frames drawn", "ms a tick", "more than for nobody"],
            [
                [
                    name,
                    f"{drawn[name]:.0f}",
                    spread(sample.map(lambda s: 1e3 * s), "{:.2f}"),
                    f"{1e3 * (sample.median - base.median):.2f}",
                ]
                for name, sample in found.items()
            ],
            [
                f"{ticks} ticks of {BOARD} with a frame after every other one, 760 pixels wide; "
                "processor time of physics, drawing and handing the frame to each viewer, "
                "without sockets."
            ],
        )
    )


async def _filmed(viewers: int, ticks: int) -> dict[str, Any]:
    """Processor time per tick, and the number of frames drawn."""
    from plinko.app.pictures.film import Cameras, Shot
    from plinko.app.rooms.independent import IndependentRoom
    from plinko.app.rooms.pending import DropCommand

    room = IndependentRoom("bench", Board.preset(BOARD), tick_rate=60, max_balls=BALLS)
    for seed in range(BALLS):
        room.drop(DropCommand(seed))
    cameras = Cameras(1, max(VIEWERS))
    shot = Shot(room.id, WIDTH, "light", 1000)
    watching = [await cameras.open(room, shot) for _ in range(viewers)]
    seen = [number for _, number, _ in watching]
    before = time.process_time()
    for tick in range(ticks):
        room.step(watched=False)
        if tick % 2:
            cameras.ticked(0.0, 0.0)
            frames = await asyncio.gather(
                *(camera.newest(n) for (camera, _, _), n in zip(watching, seen, strict=True))
            )
            seen = [number for number, _ in frames]
    spent = (time.process_time() - before) / ticks
    drawn = cameras.drawn
    cameras.close()
    return {"cpu": spent, "drawn": drawn}


def _verdict(good: bool) -> str:
    return "yes" if good else "NO"
