"""Live pictures of rooms: a camera films a room while somebody watches, once for all who do.

A camera draws when the room has moved and a viewer is ready for a frame: nothing is drawn of a room
that sleeps, for viewers that do not read, or for nobody. All cameras share one process, and who
watches pays for it: where nobody has any time left to spend, frames come as fast as it comes in.
"""

import asyncio
import functools
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from app.computing.pool import Workers
from app.concurrency.signal import Signal
from app.errors import BusyError, RoomFullError
from app.pictures.frame import Still, draw, moment_of, still_of
from app.render.parts.view import check_size
from app.render.theme import named
from app.rooms.room import Room

BOUNDARY = "plinko-frame"
PART_HEAD = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode()
"""What comes before each frame of a stream."""

TRAIL_SECONDS = 0.16  # that a ball's trail lasts, as on the page
LIT_SECONDS = 0.6  # that a bin stays lit


@dataclass(frozen=True, slots=True)
class Shot:
    """What a camera films: a room, in one size, theme and rate.

    Raises InvalidValueError that names a width or theme that no picture can have.
    """

    room: str
    width: int
    theme: str
    fps: int

    def __post_init__(self) -> None:
        check_size("width", self.width)
        named(self.theme)


class Purse(Protocol):
    """What each address may have computed, in s of a core."""

    def settle(self, key: str, now: float, seconds: float) -> None:
        """Charge what was computed."""

    def wait(self, key: str, now: float) -> float:
        """How long until the address has something left, in s."""


class Camera:
    """Films one shot for all its viewers."""

    def __init__(
        self,
        room: Room,
        shot: Shot,
        workers: Workers,
        clock: Callable[[], float],
        purse: Purse | None,
    ) -> None:
        self.room = room
        self.shot = shot
        self.viewers: Counter[str] = Counter()  # by address
        self.frames = 0  # drawn
        self.part = b""  # the last frame, as a part of the stream
        self._workers = workers
        self._clock = clock
        self._purse = purse
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
        """Time has passed: film the room if it has moved."""
        moment = moment_of(self.room)
        if moment != self._moment:
            self._moment = moment
            self._moved.set()

    async def newest(self, seen: int) -> tuple[int, bytes]:
        """The number of the newest frame and the frame, once there is one after number `seen`.

        An empty frame says that there will be no more, because the server stops.
        Raises what drawing failed with.
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
        self._drawn.send()

    async def run(self) -> None:
        """Film until cancelled; a failure ends it and goes to the viewers."""
        try:
            await self._run()
        except Exception as error:  # noqa: BLE001 - whoever waits for a frame gets it
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
        work = functools.partial(draw, self._still(), "jpg", self.shot.width, self.shot.theme)
        try:
            done = await self._workers.measured(work)
        except BusyError:
            self._moved.set()  # the frame is given up; the next try comes in its turn
            self._wanted.set()
            return
        self._charge(done.seconds)
        if done.error is not None:
            raise done.error
        self.part = _part(done.value)
        self.frames += 1
        self._drawn.send()

    def _charge(self, seconds: float) -> None:
        """Have those who watch pay for a frame, each the same."""
        if self._purse is None:
            return
        now, share = self._clock(), seconds / max(self.viewers.total(), 1)
        for address, count in self.viewers.items():
            self._purse.settle(address, now, share * count)

    def _until_paid(self) -> float:
        """Seconds until somebody who watches can pay for the next frame."""
        if self._purse is None:
            return 0.0
        now = self._clock()
        return min((self._purse.wait(address, now) for address in self.viewers), default=0.0)

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
        return still.lively(_trails(self._past), tuple(self._hits))


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


MAX_CAMERAS = 8  # that film at once; those of one room and appearance are one
MAX_VIEWERS = 200  # of all cameras


class Cameras:
    """The cameras that film now; a watcher of the ticker. For the event loop's thread only."""

    def __init__(
        self,
        max_cameras: int,
        max_viewers: int,
        *,
        clock: Callable[[], float] = time.monotonic,
        purse: Purse | None = None,
    ) -> None:
        self.max_cameras = max_cameras
        self.max_viewers = max_viewers
        self.frames = 0  # drawn by cameras that film no more
        self._clock = clock
        self._purse = purse
        self._workers = Workers(1, max_cameras)
        self._cameras: dict[Shot, tuple[Camera, asyncio.Task[None]]] = {}

    @property
    def running(self) -> int:
        """How many film now."""
        return len(self._cameras)

    @property
    def viewers(self) -> int:
        """How many watch, over all cameras."""
        return sum(camera.viewers.total() for camera, _ in self._cameras.values())

    @property
    def drawn(self) -> int:
        """Frames drawn so far, by all cameras there ever were."""
        return self.frames + sum(camera.frames for camera, _ in self._cameras.values())

    def films(self, room_id: str) -> bool:
        """Whether somebody watches pictures of this room."""
        return any(shot.room == room_id for shot in self._cameras)

    async def open(self, room: Room, shot: Shot, address: str = "") -> tuple[Camera, int, bytes]:
        """A camera for one more viewer at this address, with its newest frame; `leave` it then.

        Raises BusyError when too many cameras film already, and RoomFullError when too many watch.
        """
        camera = self._join(room, shot, address)
        try:
            return camera, *await camera.newest(0)
        except BaseException:
            self.leave(camera, address)
            raise

    def _join(self, room: Room, shot: Shot, address: str) -> Camera:
        if self.viewers >= self.max_viewers:
            raise RoomFullError(f"{self.max_viewers} watch live pictures already")
        if shot not in self._cameras:
            if len(self._cameras) >= self.max_cameras:
                raise BusyError(f"{self.max_cameras} cameras film already")
            camera = Camera(room, shot, self._workers, self._clock, self._purse)
            self._cameras[shot] = camera, asyncio.create_task(camera.run())
        camera, _ = self._cameras[shot]
        camera.viewers[address] += 1
        return camera

    def leave(self, camera: Camera, address: str = "") -> None:
        """A viewer at this address goes; the last one stops the camera."""
        camera.viewers -= Counter([address])
        if not camera.viewers:
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
