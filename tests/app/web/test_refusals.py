"""Every request that REST refuses for its values: the status, the code, the field and the words."""

import json
from typing import Any
from urllib.parse import quote

import httpx
import pytest

from plinko.engine import drop
from plinko.engine.parameters import SolverName
from tests.app.conftest import TINY
from tests.kit.problems import problem

STATUS = {"unknown-board": 404, "unknown-room": 404, "unknown-session": 404, "not-found": 404}

EIGHT = "drops/triangle-8/42"
SIXTEEN = "drops/triangle-16/42"
TWELVE = "boards/triangle-12"
HUGE = "9" * 30
ZEROS = "0" * 64


def refused(answer: httpx.Response, code: str, field: str | None, *words: str) -> None:
    found = problem(answer, STATUS.get(code, 422), code, *words)
    assert found.get("field") == field


def ids(value: object) -> str:
    return repr(value)[:60]


ADDRESSES: list[tuple[str, str, str | None, str]] = [
    # Boards and places that are not there.
    ("boards/nope", "unknown-board", "board", "nope"),
    ("drops/nope/42", "unknown-board", "board", "nope"),
    ("boards/triangle-99", "unknown-board", "board", "triangle-99"),
    ("drops/triangle-99/42", "unknown-board", "board", "triangle-99"),
    (f"boards/{ZEROS}", "unknown-board", "board", "board '000"),
    (f"drops/{ZEROS}/42", "unknown-board", "board", "board '000"),
    ("boards/nowhere/odds", "unknown-board", "board", "nowhere"),
    ("boards/nope/density.png", "unknown-board", "board", "nope"),
    ("boards/..%2Fetc", "not-found", None, ""),
    ("drops/..%2Fetc/42", "not-found", None, ""),
    ("nothing", "not-found", None, "/api/v1/nothing"),
    ("rooms/nope", "unknown-room", "room", "nope"),
    ("rooms/triangle-99", "unknown-room", "room", "triangle-99"),
    ("rooms/0123456789abcdef", "unknown-room", "room", "0123456789abcdef"),
    ("rooms/nope/stream.mjpg", "unknown-room", "room", "nope"),
    ("rooms/main/draw", "not-found", "room", "main"),
    ("sessions/none", "unknown-session", "session", "none"),
    # Names of parameters.
    (f"{EIGHT}?solvr=stepped", "invalid-value", "solvr", "x, aim, solver, dt, substeps"),
    (f"{EIGHT}?x=0&x=1", "invalid-value", "x", "given 2 times: '0', '1'"),
    (f"{EIGHT}.png?widht=300", "invalid-value", "widht", "width, theme"),
    (f"{EIGHT}/frames?fps=60&FPS=1", "invalid-value", "FPS", "fps"),
    ("boards?limit=3", "invalid-value", "limit", "the parameters are: digest"),
    ("rooms?page=2", "invalid-value", "page", "id, mode, after, limit"),
    ("rooms/main/log?from=3", "invalid-value", "from", "first, limit"),
    ("scenes?scene=sandbox", "invalid-value", "scene", "none"),
    # Starts and solvers.
    (f"{SIXTEEN}?x=-1e9", "bad-parameter", "x", "x"),
    (f"{SIXTEEN}?x=1e9", "bad-parameter", "x", "x"),
    (f"{SIXTEEN}?x=abc", "invalid-value", "x", "x"),
    (f"{SIXTEEN}?aim=9", "bad-parameter", "aim", "9"),
    (f"{SIXTEEN}?dt=soon", "invalid-value", "dt", "dt"),
    (f"{SIXTEEN}?substeps=1.5", "invalid-value", "substeps", "substeps"),
    (f"{SIXTEEN}?solver=magic", "bad-parameter", "solver", "solver"),
    (f"{SIXTEEN}?solver=stepped&dt=0", "bad-parameter", "dt", "dt"),
    (f"{SIXTEEN}?solver=stepped&dt=nan", "invalid-value", "dt", "dt"),
    (f"{SIXTEEN}?solver=stepped&dt=-0.01", "bad-parameter", "dt", "dt"),
    (f"{SIXTEEN}?solver=stepped&substeps=0", "bad-parameter", "substeps", "substeps"),
    (f"{SIXTEEN}?solver=stepped&dt=0.000001", "invalid-value", "dt", "dt"),
    (f"{SIXTEEN}?solver=stepped&dt=0.01&substeps=1000", "invalid-value", "dt", "dt"),
    (f"{SIXTEEN}?solver=stepped&certainty=true", "bad-parameter", "solver", "use 'exact'"),
    (f"{SIXTEEN}?solver=stepped&certified=true", "invalid-value", "certified", "'stepped'"),
    (f"{EIGHT}?dt=0.01", "invalid-value", "dt", "belongs to the solver 'stepped', not to 'exact'"),
    (f"{EIGHT}?solver=exact&substeps=4", "invalid-value", "substeps", "to the solver 'stepped'"),
    # Pictures.
    (f"{SIXTEEN}/frames?fps=0", "invalid-value", "fps", "0"),
    (f"{SIXTEEN}/frames?fps=-1", "invalid-value", "fps", "-1"),
    (f"{SIXTEEN}/frames?fps=nan", "invalid-value", "fps", "nan"),
    (f"{SIXTEEN}/frames?fps=1e9", "invalid-value", "fps", "1e9"),
    (f"{SIXTEEN}/frames?fps=many", "invalid-value", "fps", "many"),
    (f"{EIGHT}.png?width=wide", "invalid-value", "width", "wide"),
    (f"{EIGHT}.apng?width=10", "invalid-value", "width", "10"),
    (f"{EIGHT}.png?t=-1", "invalid-value", "t", "-1"),
    (f"{EIGHT}.png?t=nan", "invalid-value", "t", "nan"),
    (f"{EIGHT}.jpg?t=soon", "invalid-value", "t", "soon"),
    (f"{EIGHT}.gif?fps=0", "invalid-value", "fps", "0"),
    (f"{EIGHT}.gif?fps=61", "invalid-value", "fps", "61"),
    (f"{EIGHT}.png?x=99", "bad-parameter", "x", "99"),
    (f"{EIGHT}.gif?aim=99", "bad-parameter", "aim", "99"),
    (f"{EIGHT}.png?x=0&aim=0", "bad-parameter", "aim", "0.0"),
    (f"{TWELVE}/density.png?drops=0", "invalid-value", "drops", "0"),
    (f"{TWELVE}/density.png?drops=10001", "invalid-value", "drops", "10001"),
    (f"{TWELVE}/density.png?seed=1&drops={HUGE}", "invalid-value", "drops", HUGE),
    (f"{TWELVE}/density.png?seed=abc", "bad-seed", "seed", "abc"),
    (f"{TWELVE}/histogram.png?drops=-1", "invalid-value", "drops", "-1"),
    (f"{TWELVE}/histogram.png?seed={2**64 - 1}", "bad-seed", "seed", "2^64"),
    (f"{TWELVE}/sheet.png?drops=257", "invalid-value", "drops", "257"),
    (f"{TWELVE}/sheet.png?drops=-1", "invalid-value", "drops", "-1"),
    (f"{TWELVE}/sheet.png?columns=99", "invalid-value", "columns", "99"),
    # Rooms.
    ("rooms?mode=quiet", "invalid-value", "mode", "quiet"),
    ("rooms/main/stream.mjpg?width=7", "invalid-value", "width", "7"),
    ("rooms/main/stream.mjpg?fps=0", "invalid-value", "fps", "0"),
    (f"rooms/main/log?first={HUGE}", "invalid-value", "first", HUGE),
    (f"rooms/main/log?limit={HUGE}", "invalid-value", "limit", HUGE),
    (f"log?since={HUGE}", "invalid-value", "since", HUGE),
]


@pytest.mark.parametrize(("path", "code", "field", "words"), ADDRESSES, ids=ids)
def test_an_address_is_refused_for_what_is_wrong(
    http: httpx.Client, path: str, code: str, field: str | None, words: str
) -> None:
    refused(http.get(f"/api/v1/{path}"), code, field, words)


def test_an_unknown_board_is_named_but_not_at_length(http: httpx.Client) -> None:
    for path in ("boards/{}", "drops/{}/42"):
        found = problem(http.get(f"/api/v1/{path.format('x' * 3000)}"), 404, "unknown-board")
        assert len(found["detail"]) < 3200


@pytest.mark.parametrize("seed", ["-1", str(2**64), "abc", "1.5", "1e3", "%20", "NaN", "٣"])
def test_a_bad_seed_is_named(http: httpx.Client, seed: str) -> None:
    named = "" if seed in ("%20", "٣") else seed
    for suffix in ("", ".png", "/frames"):
        refused(http.get(f"/api/v1/drops/triangle-16/{seed}{suffix}"), "bad-seed", "seed", named)


DECIMALS = ("0_0.1", "1e-1_0", "0.1\n", " 0.1", "0.1 ", "٠.١", "nan", "inf")
WHOLES = ("1_0", "10\n", " 10", "١", "1.0", "1e1", "")


@pytest.mark.parametrize(
    ("path", "field", "wrong"),
    [
        (f"{EIGHT}?x=", "x", DECIMALS),
        (f"{EIGHT}?aim=", "aim", DECIMALS),
        (f"{EIGHT}?solver=stepped&dt=", "dt", DECIMALS),
        (f"{EIGHT}.png?t=", "t", DECIMALS),
        (f"{EIGHT}/frames?fps=", "fps", DECIMALS),
        (f"{EIGHT}?solver=stepped&substeps=", "substeps", WHOLES),
        (f"{EIGHT}.png?width=", "width", WHOLES),
        (f"{EIGHT}.gif?fps=", "fps", WHOLES),
        (f"{TWELVE}/density.png?drops=", "drops", WHOLES),
        (f"{TWELVE}/sheet.png?columns=", "columns", WHOLES),
        ("rooms?limit=", "limit", WHOLES),
        ("rooms/main/log?first=", "first", WHOLES),
        ("rooms/main/stream.mjpg?fps=", "fps", WHOLES),
        ("players/nobody/plays?limit=", "limit", WHOLES),
        ("log?since=", "since", WHOLES),
    ],
)
def test_a_number_is_a_plain_decimal_or_plain_digits(
    http: httpx.Client, path: str, field: str, wrong: tuple[str, ...]
) -> None:
    for spelt in wrong:
        refused(http.get(f"/api/v1/{path}{quote(spelt)}"), "invalid-value", field)


THEMES = ["", "blue", "Light", "light · Moon", "日本", "a\nb: c", "\0"]


WIDTHS = ["-1", "0", "2049", HUGE]


@pytest.mark.parametrize(
    ("field", "value"), [*(("theme", each) for each in THEMES), *(("width", w) for w in WIDTHS)]
)
def test_theme_and_width_are_checked_before_they_name_anything(
    http: httpx.Client, field: str, value: str
) -> None:
    many = (f"{TWELVE}/{kind}.png" for kind in ("density", "histogram", "sheet"))
    one = (f"{EIGHT}.{suffix}" for suffix in ("png", "gif", "mp4"))
    for path in (*one, *many, "rooms/main/frame.png", "rooms/main/stream.mjpg"):
        for headers in ({}, {"if-none-match": "*"}):  # which would match any ETag
            answer = http.get(f"/api/v1/{path}?{field}={quote(value)}", headers=headers)
            refused(answer, "invalid-value", field, repr(value))


NARROW = [{"x": -1.5 + 0.1 * i, "y": 1.0, "radius": 0.01} for i in range(1, 30)]
CLOSED = {**TINY, "pegs": NARROW}  # a fence whose gaps no ball passes
BESIDE = [{"x": x, "y": 1.0, "radius": 0.05} for x in (0.0, 0.02)]
LEVEL = [{"x1": -0.5, "y1": 1.0, "x2": 0.5, "y2": 1.0}]
REST = "a ball that starts above it, at x = 0, can come to rest there"
GALTON = {"scene": "galton", "radii": [0.1, 0.2]}
TOUCHING = "interacting-triangle-8"
STEPPED = {"solver": "stepped", "dt": 1e-3, "substeps": 500}
SCENE = {"scene": "sandbox"}
NO_BOARD = "is not a name, a digest or a board object"


def tiny(**changes: Any) -> dict[str, Any]:
    return {**TINY, **changes}


BODIES: list[tuple[str, Any, str, str | None, str]] = [
    # Boards.
    ("boards/check", tiny(pegs=BESIDE), "bad-board", "pegs[1]", "overlaps"),
    ("boards", tiny(ball={"radius": -1.0}), "bad-board", "ball.radius", "-1"),
    ("boards", tiny(pegs=[NARROW[0] | {"radius": 0.0}]), "bad-board", "pegs[0].radius", "0"),
    ("boards", tiny(bins={"edges": [-1.5, 0.0, 0.0]}), "bad-board", "bins.edges[2]", "0"),
    ("boards", tiny(pegs=[], walls=LEVEL, bins={"edges": [-9, 9]}), "bad-board", "walls[0]", REST),
    ("boards", tiny(gravity=1e-6), "bad-board", "gravity", "in free fall a ball takes 2000 s"),
    ("boards", CLOSED, "bad-board", "ball.radius", "cannot pass from the start to the bins"),
    ("drops", {"board": CLOSED, "seed": 1}, "bad-board", "ball.radius", "cannot pass"),
    ("rooms", {"board": CLOSED}, "bad-board", "ball.radius", "cannot pass"),
    ("drops", {"board": 7}, "bad-board", "board", f"7 {NO_BOARD}"),
    ("drops", {"board": None}, "bad-board", "board", f"None {NO_BOARD}"),
    ("drops", {"board": {"pegs": 7}}, "bad-board", "pegs", "7"),
    ("drops", {"board": "nope"}, "unknown-board", "board", "nope"),
    ("drops", {"board": "/etc/passwd"}, "unknown-board", "board", "/etc/passwd"),
    ("drops", {"board": "{}"}, "unknown-board", "board", "{}"),
    ("rooms", {}, "bad-board", "board", f"None {NO_BOARD}"),
    ("rooms", {"board": [1]}, "bad-board", "board", f"[1] {NO_BOARD}"),
    ("rooms", {"board": {"pegs": 7}}, "bad-board", "pegs", "7"),
    # Drops.
    ("drops", None, "invalid-value", "body", "null"),
    ("drops", [], "invalid-value", "body", "array"),
    ("drops", {}, "invalid-value", "board", "board"),
    ("drops", {"board": "triangle-16", "sede": 1}, "invalid-value", "sede", "sede"),
    ("drops", {"board": "triangle-16", "x": "left"}, "invalid-value", "x", "left"),
    ("drops", b'{"board":"triangle-16","x":1e400}', "invalid-value", "x", "1e400"),
    ("drops", {"board": "triangle-16", "solver": "magic"}, "invalid-value", "solver", "magic"),
    ("drops", {"board": "triangle-16", "dt": "fast"}, "invalid-value", "dt", "str"),
    ("drops", {"board": "triangle-8", "dt": 0.01}, "invalid-value", "dt", "0.01"),
    ("drops", {"board": "triangle-16", **STEPPED}, "invalid-value", "dt", "0.001 in 500"),
    # Many drops.
    ("simulate", {"drops": "many"}, "invalid-value", "drops", "str"),
    ("simulate", {"drops": 0}, "invalid-value", "drops", "0"),
    ("simulate", {"drops": 10_001}, "invalid-value", "drops", "10001"),
    ("simulate", {"seed": "-1"}, "bad-seed", "seed", "-1"),
    ("simulate", {"seed": str(2**64 - 50)}, "bad-seed", "seed", str(2**64 + 49)),
    ("simulate", {"solver": "stepped", "dt": 1e-7}, "invalid-value", "dt", "1e-07"),
    ("simulate", {"solver": "stepped", "dt": 7.0}, "bad-parameter", "dt", "7.0"),
    ("simulate", {"dt": 0.01}, "invalid-value", "dt", "0.01"),
    ("payouts", {"risk": "huge"}, "bad-parameter", "risk", "huge"),
    ("payouts", {"drops": 0}, "invalid-value", "drops", "drops 0"),
    ("seeds", {"bin": 9}, "bad-parameter", "bin", "9"),
    ("seeds", {"bin": -1}, "bad-parameter", "bin", "-1"),
    ("seeds", {"bin": 0, "count": 0}, "invalid-value", "count", "0"),
    ("seeds", {"bin": 0, "drops": 10_001}, "invalid-value", "drops", "10001"),
    ("seeds", {"bin": 0, "after": "x"}, "bad-seed", "seed", "x"),
    ("seeds", {"bin": 0, "after": str(2**64 - 1)}, "invalid-value", "after", str(2**64 - 1)),
    ("seeds", {"bin": 0, "aim": 5.0}, "bad-parameter", "aim", "5.0"),
    # Rooms and what happens in them.
    ("rooms", [], "invalid-value", "body", "array"),
    ("rooms", {"mode": 5}, "invalid-value", "mode", "int"),
    ("rooms", {"board": "triangle-8", "mode": "magnetic"}, "invalid-value", "mode", "magnetic"),
    ("rooms", {"scene": "moon"}, "invalid-value", "scene", "'moon' is not one of: sandbox, galton"),
    ("rooms", {"scene": {"balls": 3}}, "invalid-value", "scene", "not one of: sandbox, galton"),
    ("rooms", {"scene": 7}, "invalid-value", "scene", "not an object"),
    ("rooms", SCENE | {"board": "classic"}, "invalid-value", "board", "either a board or a scene"),
    ("rooms", {"scene": SCENE | {"balls": 10**5}}, "invalid-value", "balls", "not from 0 to 1000"),
    ("rooms", {"scene": SCENE | {"gravity": "Pluto"}}, "invalid-value", "gravity", "'Pluto'"),
    ("rooms", {"scene": SCENE | {"seed": -1}}, "bad-seed", "seed", "-1"),
    ("rooms", {"scene": GALTON}, "invalid-value", "radii", "'galton' has no 'radii'"),
    ("rooms/nope/drops", {}, "unknown-room", "room", "nope"),
    ("rooms/triangle-99/drops", {}, "unknown-room", "room", "triangle-99"),
    ("rooms/0123456789abcdef/drops", {}, "unknown-room", "room", "0123456789abcdef"),
    ("rooms/main/drops", {"name": "<b>Ada</b>"}, "invalid-value", "name", "<b>Ada</b>"),
    ("rooms/main/drops", {"name": "Ada\u202e"}, "invalid-value", "name", r"Ada\u202e"),
    ("rooms/main/drops", {"name": ""}, "invalid-value", "name", "''"),
    ("rooms/main/drops", {"name": "x" * 26}, "invalid-value", "name", "xxx"),
    ("rooms/main/drops", {"name": 5}, "invalid-value", "name", "5"),
    ("rooms/main/drops", {"colour": "red"}, "invalid-value", "colour", "red"),
    ("rooms/main/drops", {"colour": "#E91E63"}, "invalid-value", "colour", "#E91E63"),
    ("rooms/main/drops", {"colour": "#e91e63;"}, "invalid-value", "colour", "#e91e63;"),
    ("rooms/main/drops", {"colour": 0}, "invalid-value", "colour", "0"),
    ("rooms/main/drops", {"stake": 10**12}, "invalid-value", "stake", str(10**12)),
    ("sessions", {"commitment": "xyz"}, "invalid-value", "commitment", "xyz"),
    ("sessions", {"room": TOUCHING, "commitment": ZEROS}, "invalid-value", "room", TOUCHING),
]
MANY = ("simulate", "payouts", "seeds")


@pytest.mark.parametrize(("path", "body", "code", "field", "words"), BODIES, ids=ids)
def test_a_body_is_refused_for_what_is_wrong(
    http: httpx.Client, path: str, body: Any, code: str, field: str | None, words: str
) -> None:
    if path in MANY:
        body = {"board": "triangle-8", **body}
    content = body if isinstance(body, bytes) else json.dumps(body)
    refused(http.post(f"/api/v1/{path}", content=content), code, field, words)


def test_bad_seeds_and_numbers_that_json_does_not_have_are_named(http: httpx.Client) -> None:
    seeds: list[object] = [-1, 2**64, 10**30, "abc", "-1", 1.5, True, [], {}, ""]
    for path, board in (("drops", '"board":"triangle-16",'), ("rooms/main/drops", "")):
        for seed in seeds:
            answer = http.post(f"/api/v1/{path}", content=f'{{{board}"seed":{json.dumps(seed)}}}')
            refused(answer, "bad-seed", "seed", repr(seed))
        for text in ("NaN", "Infinity", "-Infinity"):
            answer = http.post(f"/api/v1/{path}", content=f'{{{board}"seed":1,"x":{text}}}')
            refused(answer, "invalid-value", "x", text)


def test_what_is_no_json_is_malformed(http: httpx.Client) -> None:
    deep = (b"[" * 100_000, b'{"board":' + b"[" * 100_000, b'{"board":' + b'{"a":' * 10_000)
    for body in (b"", b"{", b"\xff\xfe", *deep):
        problem(http.post("/api/v1/drops", content=body), 400, "malformed", "JSON")


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        ({"seed": -1}, "bad-record", "-1"),
        ({"board": "nope"}, "bad-record", "nope"),
        ({"board": 7}, "bad-record", "7"),
        ({"solver": "magic"}, "bad-record", "magic"),
        ({"x": "left"}, "bad-record", "left"),
        ({"dt": 1e-6, "substeps": 1000}, "invalid-value", "1e-06"),
    ],
)
def test_a_record_that_cannot_be_checked_is_refused(
    http: httpx.Client, changes: dict[str, Any], code: str, words: str
) -> None:
    solver: SolverName = "stepped" if "dt" in changes else "exact"
    body = drop("triangle-16", 42, solver=solver).to_dict() | changes
    refused(http.post("/api/v1/verify", json=body), code, next(iter(changes)), words)


def test_an_unknown_path_is_not_found_by_whatever_method(http: httpx.Client) -> None:
    for method in ("GET", "POST", "PUT", "DELETE", "PATCH"):
        for path in ("/api/v1/nothing", "/nothing.js", "/app/main.py", "/api/v1/rooms/a/b/c"):
            problem(http.request(method, path), 404, "not-found", path)


def test_another_method_is_refused_with_those_that_are_allowed(http: httpx.Client) -> None:
    pages = [("POST", path, "GET, HEAD") for path in ("/", "/index.html", "/js/play/main.js")]
    for method, path, allowed in (*pages, ("DELETE", "/api/v1/boards", "GET, HEAD, POST")):
        refusal = http.request(method, path)
        problem(refusal, 405, "method-not-allowed", method)
        assert refusal.headers["allow"] == allowed
