"""Live pictures of rooms: one camera films a room for all its viewers.

A camera draws a frame when the room has moved and a viewer is ready for it. It draws nothing while
the room sleeps or no viewer reads. All cameras share one worker process. The viewers' addresses pay
for its time; once their budgets are spent, frames come only as fast as the budgets refill.
"""

import asyncio
import functools
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from plinko.app.computing.pool import Workers
from plinko.app.concurrency.single_flight import Signal
from plinko.app.errors import BusyError, RoomFullError
from plinko.app.pictures.frame import Still, draw, moment_of, still_of
from plinko.app.render.parts.view import check_width
from plinko.app.render.theme import named
from plinko.app.rooms.room import Room

BOUNDARY = "plinko-frame"
PART_HEAD = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode()
"""Bytes before each frame of a stream."""

TRAIL_SECONDS = 0.16  # length of a ball's trail, as on the page
LIT_SECONDS = 0.6  # how long a bin stays lit after a landing


@dataclass(frozen=True, slots=True)
class Shot:
    """What a camera films: a room, in one size, theme and rate.

    Raises InvalidValueError if the width or theme is invalid.
    """

    room: str
    width: int
    theme: str
    fps: int

    def __post_init__(self) -> None:
        check_width(self.width)
        named(self.theme)


class Budget(Protocol):
    """The computing time that each address may use, in CPU seconds."""

    def settle(self, key: str, now: float, seconds: float) -> None:
        """Charge the address `key` for `seconds` that were computed."""

    def wait(self, key: str, now: float) -> float:
        """Seconds until the address `key` has budget again."""


class Camera:
    """Films one shot for all its viewers."""

    def __init__(
        self,
        room: Room,
        shot: Shot,
        workers: Workers,
        clock: Callable[[], float],
        budget: Budget | None,
    ) -> None:
        self.room = room
        self.shot = shot
        self.viewers: Counter[str] = Counter()  # by address
        self.frames = 0  # drawn
        self.part = b""  # the newest frame, as a part of the stream
        self._workers = workers
        self._clock = clock
        self._budget = budget
        self._failure: Exception | None = None
        self._stopped = False
        self._moved = asyncio.Event()
        self._moved.set()
        self._wanted = asyncio.Event()
        self._drawn = Signal()
        self._moment = moment_of(room)
        self._past: deque[tuple[float, npt.NDArray[np.void]]] = deque()
        self._histogram = room.stats().histogram
        self._hits: dict[int, float] = {}

    def ticked(self) -> None:
        """Called after each tick: note whether the room has moved."""
        moment = moment_of(self.room)
        if moment != self._moment:
            self._moment = moment
            self._moved.set()

    async def newest(self, seen: int) -> tuple[int, bytes]:
        """Wait for a frame after number `seen`, and return the newest with its number.

        An empty frame is the last: the server stops. Raises the error with which drawing failed.
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
        """End the viewers' streams."""
        self._stopped = True
        self._drawn.send()

    async def run(self) -> None:
        """Film until cancelled; a failure ends the camera and is raised to its viewers."""
        try:
            await self._run()
        except Exception as error:  # noqa: BLE001 - `newest` raises it to the viewers
            self._failure = error
            self._drawn.send()

    async def _run(self) -> None:
        due = self._clock()
        while True:
            await self._next_move()
            await self._wanted.wait()
            self._moved.clear()
            self._wanted.clear()
            await self._film()
            due = max(due + 1.0 / self.shot.fps, self._clock() - 1.0 / self.shot.fps)
            await asyncio.sleep(max(due - self._clock(), self._until_paid(), 0.0))

    async def _next_move(self) -> None:
        """Wait until the room has moved or the light on a bin goes out."""
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
        work = functools.partial(draw, self._still(), "jpg", self.shot.width, self.shot.theme)
        try:
            done = await self._workers.measured(work)
        except BusyError:
            self._moved.set()  # skip this frame; `_run` tries again when the next one is due
            self._wanted.set()
            return
        self._charge(done.seconds)
        if done.error is not None:
            raise done.error
        self.part = _part(done.value)
        self.frames += 1
        self._drawn.send()

    def _charge(self, seconds: float) -> None:
        """Charge each viewer the same share of a frame."""
        if self._budget is None:
            return
        now, share = self._clock(), seconds / max(self.viewers.total(), 1)
        for address, count in self.viewers.items():
            self._budget.settle(address, now, share * count)

    def _until_paid(self) -> float:
        """Seconds until a viewer can pay for the next frame."""
        if self._budget is None:
            return 0.0
        now = self._clock()
        return min((self._budget.wait(address, now) for address in self.viewers), default=0.0)

    def _still(self) -> Still:
        """The room now, with trails behind the balls and light on the bins hit recently."""
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
            return still  # in a box with piles of balls, trails would hide the balls
        return replace(still, trails=_trails(self._past), lit=tuple(self._hits))


def _trails(
    past: deque[tuple[float, npt.NDArray[np.void]]],
) -> dict[int, npt.NDArray[np.float64]]:
    """Positions of each ball, the newest first, by the ball's id."""
    places: dict[int, list[tuple[float, float]]] = {}
    for _, bodies in reversed(past):
        for number, x, y in zip(
            bodies["id"].tolist(), bodies["x"].tolist(), bodies["y"].tolist(), strict=True
        ):
            places.setdefault(number, []).append((x, y))
    return {number: np.array(points) for number, points in places.items()}


def _part(picture: bytes) -> bytes:
    """A frame as a part of a multipart stream, followed by the head of the next part.

    Browsers show a part once they have read the head of the next, so the next head is sent at
    once. It has no Content-Length, because the length of the next frame is not yet known.
    """
    return b"".join([picture, b"\r\n", PART_HEAD])


MAX_CAMERAS = 8  # at the same time; viewers of the same `Shot` share one
MAX_VIEWERS = 200  # of all cameras together


class Cameras:
    """All cameras; the ticker calls them after each tick. For the event loop's thread only."""

    def __init__(
        self,
        max_cameras: int,
        max_viewers: int,
        *,
        clock: Callable[[], float] = time.monotonic,
        budget: Budget | None = None,
    ) -> None:
        self.max_cameras = max_cameras
        self.max_viewers = max_viewers
        self.frames = 0  # drawn by cameras that have ended
        self._clock = clock
        self._budget = budget
        self._workers = Workers(1, max_cameras)
        self._cameras: dict[Shot, tuple[Camera, asyncio.Task[None]]] = {}

    @property
    def running(self) -> int:
        return len(self._cameras)

    @property
    def viewers(self) -> int:
        return sum(camera.viewers.total() for camera, _ in self._cameras.values())

    @property
    def drawn(self) -> int:
        """Frames drawn since the start, by all cameras including those that have ended."""
        return self.frames + sum(camera.frames for camera, _ in self._cameras.values())

    def films(self, room_id: str) -> bool:
        return any(shot.room == room_id for shot in self._cameras)

    async def open(self, room: Room, shot: Shot, address: str = "") -> tuple[Camera, int, bytes]:
        """Add a viewer at this address; return its camera with the newest frame and its number.

        The caller must `leave` the camera. Raises BusyError if there are too many cameras,
        RoomFullError if there are too many viewers.
        """
        camera = self._join(room, shot, address)
        try:
            return camera, *await camera.newest(0)
        except BaseException:
            self.leave(camera, address)
            raise

    def _join(self, room: Room, shot: Shot, address: str) -> Camera:
        if self.viewers >= self.max_viewers:
            raise RoomFullError(f"live pictures already have {self.max_viewers} viewers, the limit")
        if shot not in self._cameras:
            if len(self._cameras) >= self.max_cameras:
                raise BusyError(
                    f"live pictures already have {self.max_cameras} cameras, the limit; request "
                    "the size, theme and rate of another viewer, or try again later"
                )
            camera = Camera(room, shot, self._workers, self._clock, self._budget)
            self._cameras[shot] = camera, asyncio.create_task(camera.run())
        camera, _ = self._cameras[shot]
        camera.viewers[address] += 1
        return camera

    def leave(self, camera: Camera, address: str = "") -> None:
        """Remove a viewer at this address; the camera ends with its last viewer."""
        camera.viewers -= Counter([address])
        if not camera.viewers:
            _, task = self._cameras.pop(camera.shot)
            task.cancel()
            self.frames += camera.frames

    def ticked(self, late: float, duration: float) -> None:
        for camera, _ in self._cameras.values():
            camera.ticked()

    def close(self) -> None:
        """End all cameras and their streams; no camera can be opened afterwards."""
        self.max_cameras = 0
        for camera, task in self._cameras.values():
            camera.stop()
            task.cancel()
        self._workers.close()
