"""Live pictures of rooms: a camera films a room while somebody watches, once for all who do.

A camera draws when the room has moved and a viewer is ready for a frame: nothing is drawn of a room
that sleeps, for viewers that do not read, or for nobody. All cameras share one thread.
"""

import asyncio
import functools
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from app.errors import BusyError, RoomFullError
from app.pictures.workers import Workers
from app.rooms.room import Room
from engine import Board

if TYPE_CHECKING:
    from app.render import BoxStage, Stage

BOUNDARY = "plinko-frame"
PART_HEAD = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode()
"""What comes before each frame of a stream."""

TRAIL_SECONDS = 0.16  # that a ball's trail lasts, as on the page
LIT_SECONDS = 0.6  # that a bin stays lit


@dataclass(frozen=True, slots=True)
class Shot:
    """What a camera films: a room, in one size, theme and rate."""

    room: str
    width: int
    theme: str
    fps: int


@dataclass(frozen=True, slots=True)
class Still:
    """A room at one moment, taken on the loop's thread and drawn on another."""

    bodies: npt.NDArray[np.void]
    facts: tuple[str, ...]
    ground: str = ""  # digest of what does not move: a room of a scene may be begun anew
    trails: dict[int, npt.NDArray[np.float64]] = field(default_factory=dict)
    lit: tuple[int, ...] = ()


def still_of(room: Room) -> Still:
    """A room as it is."""
    bodies, ground = room.world.bodies, room.ground
    if room.box is not None:
        asleep = int((bodies["asleep"] != 0).sum())
        return Still(bodies, (f"{len(bodies):,} balls", f"{asleep:,} asleep"), ground.digest)
    stats = room.stats()
    landed = sum(stats.histogram) + stats.unsettled
    return Still(bodies, (f"{len(bodies)} in flight", f"{landed:,} landed"), ground.digest)


def moment_of(room: Room) -> str:
    """What is another whenever the room looks otherwise."""
    return f"{room.id}.{room.world.tick}.{room.taken}"


def stage_of(room: Room, width: int, theme: str) -> "Stage | BoxStage":
    """Where a room's frames are painted; raises InvalidValueError. For a worker's thread."""
    from app.render import BoxStage, Stage  # noqa: PLC0415 - loaded when a picture is asked for

    ground, box = room.ground, room.box
    title = room.id if room.id == ground.name else f"{room.id}   {ground.name}"
    if box is not None:
        return BoxStage(box.place, width, theme=theme, title=title, radius=box.radius)
    assert isinstance(ground, Board)
    return Stage(ground, width, theme=theme, title=title)


class Stages:
    """The stages used last, for single frames; for workers' threads, several at once."""

    def __init__(self, most: int = 8) -> None:
        self._most = most
        self._stages: OrderedDict[
            tuple[str, str, int, str], tuple[Stage | BoxStage, threading.Lock]
        ] = OrderedDict()
        self._lock = threading.Lock()

    def draw(self, room: Room, still: Still, fmt: str, width: int, theme: str) -> bytes:
        """A frame of `room` as `png` or `jpg`; raises InvalidValueError."""
        stage, lock = self._stage(room, still.ground, width, theme)
        with lock:
            pixels = stage.frame(still.bodies, facts=still.facts)
            return stage.png(pixels) if fmt == "png" else stage.jpg(pixels)

    def _stage(
        self, room: Room, ground: str, width: int, theme: str
    ) -> "tuple[Stage | BoxStage, threading.Lock]":
        key = (room.id, ground, width, theme)
        with self._lock:
            if key not in self._stages:
                self._stages[key] = stage_of(room, width, theme), threading.Lock()
            self._stages.move_to_end(key)
            if len(self._stages) > self._most:
                self._stages.popitem(last=False)
            return self._stages[key]


class Camera:
    """Films one shot for all its viewers."""

    def __init__(self, room: Room, shot: Shot, workers: Workers, clock: Callable[[], float]):
        self.room = room
        self.shot = shot
        self.viewers = 0
        self.frames = 0  # drawn
        self.part = b""  # the last frame, as a part of the stream
        self._workers = workers
        self._clock = clock
        self._stage: Stage | BoxStage | None = None
        self._ground = ""  # digest of what the stage is of
        self._failure: Exception | None = None
        self._stopped = False
        self._moved = asyncio.Event()
        self._moved.set()
        self._wanted = asyncio.Event()
        self._drawn = asyncio.Event()
        self._moment = moment_of(room)
        self._past: deque[tuple[float, npt.NDArray[np.void]]] = deque()
        self._histogram = room.stats().histogram
        self._hits: dict[int, float] = {}

    def ticked(self) -> None:
        """Time has passed: film the room if it has moved."""
        moment = moment_of(self.room)
        if moment != self._moment:
            self._moment = moment
            self._moved.set()

    async def newest(self, seen: int) -> tuple[int, bytes]:
        """The number of the newest frame and the frame, once there is one after number `seen`.

        An empty frame says that there will be no more, because the server stops.
        Raises InvalidValueError for a size or theme that is none.
        """
        while self.frames <= seen:
            if self._stopped:
                return self.frames, b""
            if self._failure is not None:
                raise self._failure
            self._wanted.set()
            await self._drawn.wait()
        return self.frames, self.part

    def stop(self) -> None:
        """Let the viewers go."""
        self._stopped = True
        self._drawn.set()

    async def run(self) -> None:
        """Film until cancelled; a failure ends it and goes to the viewers."""
        try:
            await self._run()
        except Exception as error:  # noqa: BLE001 - whoever waits for a frame gets it
            self._failure = error
            self._drawn.set()

    async def _run(self) -> None:
        due = self._clock()
        while True:
            await self._next_move()
            await self._wanted.wait()
            self._moved.clear()
            self._wanted.clear()
            await self._film()
            due = max(due + 1.0 / self.shot.fps, self._clock() - 1.0 / self.shot.fps)
            await asyncio.sleep(max(due - self._clock(), 0.0))

    async def _next_move(self) -> None:
        """Wait until the room has moved, or a light goes out."""
        fade = min(self._hits.values(), default=None)
        if fade is None:
            await self._moved.wait()
            return
        try:
            async with asyncio.timeout(max(fade + LIT_SECONDS - self._clock(), 0.0)):
                await self._moved.wait()
        except TimeoutError:
            return

    async def _film(self) -> None:
        try:
            picture = await self._workers.run(functools.partial(self._draw, self._still()))
        except BusyError:
            self._moved.set()  # the frame is given up; the next try comes in its turn
            self._wanted.set()
            return
        self.part = _part(picture)
        self.frames += 1
        self._drawn.set()
        self._drawn = asyncio.Event()

    def _draw(self, still: Still) -> bytes:
        if self._stage is None or self._ground != still.ground:
            self._stage = stage_of(self.room, self.shot.width, self.shot.theme)
            self._ground = still.ground
        pixels = self._stage.frame(
            still.bodies, trails=still.trails, lit=still.lit, facts=still.facts
        )
        return self._stage.jpg(pixels)

    def _still(self) -> Still:
        """The room with what came before: trails behind the balls, light on bins just hit."""
        now, still = self._clock(), still_of(self.room)
        while self._past and self._past[0][0] < now - TRAIL_SECONDS:
            self._past.popleft()
        self._past.append((now, still.bodies))
        counts = self.room.stats().histogram
        for number, (old, new) in enumerate(zip(self._histogram, counts, strict=True)):
            if new > old:
                self._hits[number] = now
        self._histogram = counts
        self._hits = {n: at for n, at in self._hits.items() if at > now - LIT_SECONDS}
        if self.room.box is not None:
            return still  # where balls lie in heaps, trails would hide them
        return replace(still, trails=_trails(self._past), lit=tuple(self._hits))


def _trails(
    past: deque[tuple[float, npt.NDArray[np.void]]],
) -> dict[int, npt.NDArray[np.float64]]:
    """By ball, where it is and was, newest first."""
    places: dict[int, list[tuple[float, float]]] = {}
    for _, bodies in reversed(past):
        for number, x, y in zip(
            bodies["id"].tolist(), bodies["x"].tolist(), bodies["y"].tolist(), strict=True
        ):
            places.setdefault(number, []).append((x, y))
    return {number: np.array(points) for number, points in places.items()}


def _part(picture: bytes) -> bytes:
    """A frame as a part of a multipart stream, with the head of the part that will follow it.

    Browsers show a part when they have read the head of the next, so that head goes ahead. It can
    have no length, for that is not known yet.
    """
    return b"".join([picture, b"\r\n", PART_HEAD])


class Cameras:
    """The cameras that film now; a watcher of the ticker. For the event loop's thread only."""

    def __init__(
        self,
        max_cameras: int,
        max_viewers: int,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.max_cameras = max_cameras
        self.max_viewers = max_viewers
        self.frames = 0  # drawn by cameras that film no more
        self._clock = clock
        self.stages = Stages()
        self._workers = Workers(1, max_cameras)
        self._cameras: dict[Shot, tuple[Camera, asyncio.Task[None]]] = {}

    @property
    def running(self) -> int:
        """How many film now."""
        return len(self._cameras)

    @property
    def viewers(self) -> int:
        """How many watch, over all cameras."""
        return sum(camera.viewers for camera, _ in self._cameras.values())

    @property
    def drawn(self) -> int:
        """Frames drawn so far, by all cameras there ever were."""
        return self.frames + sum(camera.frames for camera, _ in self._cameras.values())

    async def draw(self, frame: Callable[[], bytes]) -> bytes:
        """A single frame, drawn in its turn among those of the cameras; raises BusyError."""
        return await self._workers.run(frame)

    def films(self, room_id: str) -> bool:
        """Whether somebody watches pictures of this room."""
        return any(shot.room == room_id for shot in self._cameras)

    async def open(self, room: Room, shot: Shot) -> tuple[Camera, int, bytes]:
        """A camera for one more viewer, with its newest frame; `leave` it at the end.

        Raises BusyError when too many cameras film already, RoomFullError when too many watch, and
        InvalidValueError for a shot that cannot be.
        """
        camera = self._join(room, shot)
        try:
            return camera, *await camera.newest(0)
        except BaseException:
            self.leave(camera)
            raise

    def _join(self, room: Room, shot: Shot) -> Camera:
        if self.viewers >= self.max_viewers:
            raise RoomFullError(f"{self.max_viewers} watch live pictures already")
        if shot not in self._cameras:
            if len(self._cameras) >= self.max_cameras:
                raise BusyError(f"{self.max_cameras} cameras film already")
            camera = Camera(room, shot, self._workers, self._clock)
            self._cameras[shot] = camera, asyncio.create_task(camera.run())
        camera, _ = self._cameras[shot]
        camera.viewers += 1
        return camera

    def leave(self, camera: Camera) -> None:
        """A viewer goes; the last one stops the camera."""
        camera.viewers -= 1
        if camera.viewers == 0:
            _, task = self._cameras.pop(camera.shot)
            task.cancel()
            self.frames += camera.frames

    def woke(self) -> None:
        """The ticker left its sleep."""

    def ticked(self, late: float, duration: float) -> None:
        """A tick is over."""
        for camera, _ in self._cameras.values():
            camera.ticked()

    def slept(self) -> None:
        """Nothing moves any more."""

    def close(self) -> None:
        """Stop all cameras and end the streams; none is opened afterwards."""
        self.max_cameras = 0
        for camera, task in self._cameras.values():
            camera.stop()
            task.cancel()
        self._workers.close()
