"""The page's box of touching balls gives the same bits as the server's room."""

import json
from typing import Any

import pytest

from plinko.app.rooms.touching import values
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import DEFAULTS, Scene
from plinko.engine import Board
from tests.js.conftest import MODULES, Run

_TOLD = """
const { readFileSync } = await import("node:fs");
const { Machine } = await load("solver/machine.js");
const bytes = readFileSync(new URL("solver/touching/touching.wasm", MODULES_URL));
const machine = await Machine.open(bytes);
const world = new World(machine, given.scene, given.board);
const told = [];
const see = () => {
  const { table } = world.arena;
  told.push({
    tick: world.tick, time: world.arena.time,
    pos: Array.from(table.pos), vel: Array.from(table.vel), marks: Array.from(table.marks),
  });
};
see();
for (const { tick, input } of [...given.inputs, { tick: given.tick }]) {
  while (world.tick < tick) world.step();
  see();
  if (input) world.carryOut(input);
}
return told;
""".replace("MODULES_URL", json.dumps(f"{MODULES.as_uri()}/"))

Told = list[dict[str, Any]]
Input = tuple[int, dict[str, Any]]


def told_by_page(run: Run, scene: Scene, inputs: list[Input], tick: int) -> Told:
    given = {
        "scene": scene.to_dict(),
        "board": Board.preset("galton").to_dict(),
        "inputs": [{"tick": at, "input": asked} for at, asked in inputs],
        "tick": tick,
    }
    found: Told = run(
        "solver/touching/world.js", f"async ({{ World }}, given, load) => {{ {_TOLD} }}", given
    )
    return found


def told_by_room(scene: Scene, inputs: list[Input], tick: int) -> Told:
    room = TouchingRoom("r", scene, tick_rate=60, max_balls=500)
    told: Told = []

    def see() -> None:
        table = room.world.arena._table
        n = table.n
        told.append(
            {
                "tick": room.world.tick,
                "time": room.world.arena.time,
                "pos": [*table.bodies.pos[:n].ravel().tolist(), 0.0, 0.0, 0.0, 0.0],
                "vel": [*table.bodies.vel[:n].ravel().tolist(), 0.0, 0.0, 0.0, 0.0],
                "marks": table.bodies.marks[:n].ravel().tolist(),
            }
        )

    see()
    for at, asked in [*inputs, (tick, None)]:
        while room.world.tick < at:
            room.step(watched=False)
        see()
        if asked is not None:
            room.replay({"tick": at, "input": asked})
    return told


def scene_of(**given: Any) -> Scene:
    return Scene.of({"scene": "sandbox", **given}, tick_rate=60, max_balls=500)


def put(x: float, y: float, **given: float) -> dict[str, Any]:
    usual = {"density": 80.0, "restitution": 0.9, "friction": 0.2, "radius": 0.11}
    return {"type": "add", "x": x, "y": y, **usual, **given}


SCENES: dict[str, tuple[Scene, list[Input], int]] = {
    "as it opens": (scene_of(gravity=1.62), [], 900),
    "thrown and held": (
        scene_of(balls=40, seed="7", speed=3.0, gravity=3.72),
        [
            (20, put(0.25, 0.5, vx=4.0, vy=-2.5)),
            (45, {"type": "drag", "ball": 3, "x": 1.0, "y": 0.75}),
            (60, {"type": "drag", "ball": 3, "x": -2.0, "y": 1.25}),
            (75, {"type": "release", "ball": 3}),
            (90, {"type": "kick", "ball": 5, "vx": 2.5, "vy": -7.0, "omega": 3.0}),
            (120, {"type": "remove", "ball": 8}),
            (121, put(-1.5, 0.5, radius=0.3, density=900.0, restitution=0.3)),
        ],
        600,
    ),
    "asleep and woken": (
        scene_of(balls=30, restitution=0.1, friction=0.8, seed="3"),
        [
            (700, {"type": "kick", "ball": 2, "vy": -6.0}),
            (900, {"type": "edit", "ball": 4, "radius": 0.25}),
            (1200, {"type": "remove", "ball": 4}),
            (1400, put(0.0, 0.5)),
        ],
        1800,
    ),
    "settings of every kind": (
        scene_of(balls=50, seed="18446744073709551615", speed=2.0, drag=0.3),
        [
            (30, {"type": "settings", "gravity": 24.79, "damping": 0.995}),
            (60, {"type": "settings", "restitution": 0.5, "density": 700.0, "friction": 0.6}),
            (90, {"type": "settings", "dt": 0.007, "substeps": 7, "correction": 0.45}),
            (140, {"type": "pause", "paused": True}),
            (140, {"type": "step"}),
            (141, {"type": "pause", "paused": False}),
            (160, {"type": "settings", "gravity": -3.0, "gravity_x": 4.0, "rolling": 0.02}),
            (170, {"type": "settings", "max_speed": 2.5, "projection": 0, "cell": 0.3}),
            (200, {"type": "settings", "drag": 0.0, "gravity": 0.0, "gravity_x": 0.0}),
            (210, {"type": "settings", "max_speed": 0.0, "projection": 1, "cell": 0.0}),
            (300, {"type": "clear"}),
            (310, put(0.0, 1.0, vx=1.0)),
        ],
        500,
    ),
    "a pile on the Galton board": (
        Scene.of({"scene": "galton", "balls": 120, "seed": "5"}, tick_rate=60, max_balls=500),
        [(200, put(0.03, 0.0, radius=0.02))],
        500,
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_page_s_box_equals_the_server_s_to_the_last_bit(run: Run, name: str) -> None:
    scene, inputs, tick = SCENES[name]
    page, room = told_by_page(run, scene, inputs, tick), told_by_room(scene, inputs, tick)
    assert len(page) == len(room) == len(inputs) + 2
    for mine, true in zip(page, room, strict=True):
        assert mine == true, f"at tick {true['tick']}"


def test_one_of_these_scenes_comes_to_rest() -> None:
    scene, inputs, _ = SCENES["asleep and woken"]
    told = told_by_room(scene, inputs, 1800)
    assert all(flags & 1 for flags in told[1]["marks"][1::4])


def test_the_page_s_diagnostics_are_the_server_s(run: Run) -> None:
    scene, inputs, tick = SCENES["thrown and held"]
    measured = _TOLD.replace("return told;", "return world.arena.diagnostics();")
    found = run(
        "solver/touching/world.js",
        f"async ({{ World }}, given, load) => {{{measured} }}",
        {
            "scene": scene.to_dict(),
            "board": None,
            "inputs": [{"tick": at, "input": asked} for at, asked in inputs],
            "tick": tick,
        },
    )
    room = TouchingRoom("r", scene, tick_rate=60, max_balls=500)
    for at, asked in inputs:
        while room.world.tick < at:
            room.step(watched=False)
        room.replay({"tick": at, "input": asked})
    while room.world.tick < tick:
        room.step(watched=False)
    true = room.diagnostics()
    for field in ("kinetic", "potential", "rotational", "total", "px", "py", "angular"):
        assert found[field] == pytest.approx(getattr(true, field), rel=1e-9, abs=1e-9)
    for field in ("contacts", "penetration", "asleep", "count", "time", "cell"):
        assert found[field] == getattr(true, field), field


def test_the_page_opens_the_scenes_that_the_server_has(run: Run) -> None:
    expected = {name: {"scene": name, **usual} for name, usual in DEFAULTS.items()}
    found = run(
        "solver/touching/values.js",
        "({ SCENES, RANGES }) => ({ scenes: SCENES, ranges: RANGES })",
    )
    assert found["scenes"] == expected
    table = values.table()
    for group in ("ball", "settings"):
        for name, entry in table[group].items():
            assert found["ranges"][name] == [entry["low"], entry["high"]], name


def test_an_invalid_scene_is_refused_by_its_field(run: Run) -> None:
    wrong: list[dict[str, Any]] = [
        {"balls": 501}, {"balls": 2.5}, {"seed": "-1"}, {"gravity": 101}, {"radii": [0.2, 0.1]},
        {"radii": [0.001, 0.1]}, {"width": None}, {"dt": 0.001, "substeps": 32, "balls": 100},
        {"balls": 400, "radii": [0.3, 0.3]},
    ]  # fmt: skip
    found = run(
        "solver/touching/values.js",
        """async ({ sceneOf }, forms, load) => {
          const { openingOf } = await load("solver/touching/scenes.js");
          const fieldOf = (form) => {
            try {
              openingOf(sceneOf(form), null);
              return null;
            } catch (error) { return error.field ?? String(error); }
          };
          return [...forms, {}].map(fieldOf);
        }""",
        wrong,
    )
    assert found == [
        "balls", "balls", "seed", "gravity", "radii", "radii", "width", "dt", "balls", None,
    ]  # fmt: skip
