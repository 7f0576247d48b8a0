"""The outsider's decoder and checker agree with the server and the engine."""

import ast
import json
import math
import struct
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.app.protocol.messages import Limits
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.stakes import payout_of
from plinko.engine import Board, drop, drop_many
from tests.app.rooms.logs import LOGS, OWN
from tests.kit.presets import SAMPLE
from tests.long import tries
from tests.outsider import checker, decoder
from tools.golden.check import SEEDS, golden

GOLDEN = Path(__file__).parents[1] / "golden"


SNAPSHOTS = json.loads((GOLDEN / "snapshots.json").read_text())["snapshots"]
PATHS = json.loads((GOLDEN / "paths.json").read_text())["messages"]


@pytest.mark.parametrize("module", [decoder, checker])
def test_an_outsider_imports_only_the_standard_library(module: Any) -> None:
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {
        name.partition(".")[0]
        for node in imports
        for name in (
            [node.module or "."]
            if isinstance(node, ast.ImportFrom)
            else [each.name for each in node.names]
        )
    }
    assert names <= sys.stdlib_module_names


# The decoder.


@pytest.mark.parametrize("example", SNAPSHOTS, ids=lambda example: example["name"])
def test_every_golden_snapshot_is_decoded_to_the_last_bit(example: dict[str, Any]) -> None:
    data = bytes.fromhex(example["hex"])
    found = decoder.snapshot(data, example["extent"], example["velocity_scale"])
    assert found == {name: example[name] for name in ("tick", "seq", "balls")}


@pytest.mark.parametrize("example", PATHS, ids=lambda example: example["name"])
def test_every_golden_path_is_decoded_to_the_last_bit_and_drawn(example: dict[str, Any]) -> None:
    found = decoder.paths(bytes.fromhex(example["hex"]))
    assert found == example["paths"]
    knots = {path["ball"]: path["knots"] for path in found}
    for drawn in example["drawn"]:
        pose = decoder.pose(knots[drawn["ball"]], drawn["at"], drawn["drag"])
        assert pose == pytest.approx(drawn["pose"], 1e-12)


@pytest.mark.parametrize("data", ["", "50", "5001010000000000000000", "530100005802000011000000"])
def test_data_that_is_no_snapshot_is_refused(data: str) -> None:
    with pytest.raises((ValueError, struct.error)):
        decoder.snapshot(bytes.fromhex(data), {}, 1.0)


PATH = bytes.fromhex(PATHS[0]["hex"])


@pytest.mark.parametrize(
    "data",
    [
        b"",
        PATH[:15],
        PATH[:-1],
        PATH + b"\0",
        b"\x50" + PATH[1:],
        b"\x46\x02" + PATH[2:],
        PATH[:16],
    ],
    ids=["nothing", "half a header", "a byte short", "one too many", "magic", "version", "header"],
)
def test_data_that_is_no_path_is_refused(data: bytes) -> None:
    with pytest.raises((ValueError, struct.error)):
        decoder.paths(data)


def hello_of(room: IndependentRoom, stream: str) -> dict[str, Any]:
    found: dict[str, Any] = msgspec.json.decode(
        msgspec.json.encode(room.hello(0.0, Limits(9, 1.0, 1), stream))
    )
    return found


def test_a_room_is_read_to_half_a_step_from_both_streams() -> None:
    board = Board.preset("triangle-12")
    room = IndependentRoom("r", board, tick_rate=60, max_balls=99)
    hello = hello_of(room, "paths")
    box, scale = hello["extent"], hello["velocity_scale"]
    half = {"x": 0.5 * (box["x_max"] - box["x_min"]) / 65535, "vx": 0.5 * scale}
    half |= {"y": 0.5 * (box["y_max"] - box["y_min"]) / 65535, "vy": 0.5 * scale}
    paths: dict[int, Any] = {}
    starts: dict[int, int] = {}
    seen = 0
    for tick in range(420):
        if tick % 12 == 0 and tick < 240:
            accepted = room.drop(DropCommand(tick))
            starts[accepted.ball] = accepted.tick
            for path in decoder.paths(room.current_path(accepted.ball)):
                paths[path["ball"]] = path["knots"]
        room.step(watched=True)
        found = decoder.snapshot(room.snapshot(), box, scale)
        assert (found["tick"], found["seq"]) == (room.world.tick, room.seq)
        for ball, row in zip(found["balls"], room.world.bodies, strict=True):
            seen += 1
            for name, step in half.items():
                assert abs(ball[name] - row[name]) <= step * (1 + 1e-9)
            now = (room.world.tick - starts[ball["id"]]) / hello["tick_rate"]
            x, y, _ = decoder.pose(paths[ball["id"]], now, hello["board"]["drag"])
            assert math.hypot(x - row["x"], y - row["y"]) < 0.15e-3
    assert seen > 4000


# The checker.


def boards() -> dict[str, Board]:
    found = {name: Board.preset(name) for name in SAMPLE}
    return found | {f"scene:{name}": scene(name).board for name in scene_names()}


@pytest.mark.long
def test_every_golden_digest_is_computed_from_the_record_alone() -> None:
    checked = 0
    for name, board in boards().items():
        form = json.loads(json.dumps(board.to_dict()))
        assert checker.board_digest(form) == golden()["drops"][name]["board_digest"]
        for solver in ("exact", "stepped"):
            digests = golden()["drops"][name][solver]
            for seed, wanted in list(zip(SEEDS, digests, strict=True))[: tries(1, 5)]:
                made = drop(board, seed, solver=solver).to_dict()
                record = json.loads(json.dumps(made))
                assert record["digest"] == wanted
                assert checker.record_errors(record, form) == []
                checked += 1
    assert checked == 2 * len(boards()) * tries(1, 5)


@pytest.mark.parametrize(
    "form",
    [
        OWN,
        {"bins": {"multipliers": [1, 2, 3]}},
        {"width": 2, "drop": {"jitter": 0.25, "reach": 0.5, "slots": [0.1]}, "pegs": []},
        {"bins": {"multipliers": [1, 2], "labels": [None, {"text": "Caf\xe9"}]}},
        {"bins": {"multipliers": [1], "labels": [{"text": "x", "colour": "#00ff00"}]}, "name": "a"},
        {"bins": {"edges": [-1, 1], "y": 5}, "ball": {"radius": 0.25}, "name": "ø"},
    ],
)
def test_defaults_are_what_the_page_says(form: dict[str, Any]) -> None:
    assert checker.board_digest(form) == Board.from_json(form).digest


def test_starts_and_batches_are_what_the_page_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plinko.engine.drops.digest.BLOCK", 8)  # 65,536 records would take minutes
    form = Board.preset("triangle-9").to_dict()
    for options in ({"solver": "exact"}, {"solver": "stepped", "dt": 0.01, "substeps": 2}):
        many = drop_many("triangle-9", [*range(20), 2**64 - 1], **options)
        records = [one.to_dict() for one in many]
        assert checker.batch_digest(records, 8) == many.digest
        for record, x in zip(records, many.x_start.tolist(), strict=True):
            zone = form["drop"]
            assert checker.start(int(record["seed"]), zone["x"], zone["jitter"]) == x


def test_a_drop_that_did_not_land_has_the_digest_of_one_way() -> None:
    made = drop("classic", x=0.0)
    assert made.bin is None
    form = Board.preset("classic").to_dict()
    assert checker.record_errors(made.to_dict(), form) == []
    assert checker.drop_digests(made.to_dict(), form).index(made.digest) == 1, "balanced"
    assert made.unsettled is not None
    assert made.unsettled.startswith("balanced")


def test_a_record_that_was_changed_is_found_out() -> None:
    form = Board.preset("triangle-8").to_dict()
    record = json.loads(json.dumps(drop("triangle-8", 1).to_dict()))
    record["impacts"][3][2] += 1e-12
    record["bin"] += 1
    assert {"digest", "landing", "bin"} <= set(checker.record_errors(record, form))


@pytest.mark.parametrize("kind", LOGS)
def test_a_log_is_checked_from_the_page_alone(kind: str) -> None:
    log = json.loads(json.dumps(LOGS[kind]()))
    assert checker.log_errors(log) == []
    assert checker.log_errors(log | {"room": "other"}) == ["digest"]


@pytest.mark.parametrize("stake", [0, 1, 3, 10, 999_999_999])
@pytest.mark.parametrize("score", [0.1, 0.3, 5.6, 110.0, 1e-7])
def test_payouts_are_what_the_page_says(stake: int, score: float) -> None:
    assert checker.payout(stake, score) == payout_of(stake, score)
