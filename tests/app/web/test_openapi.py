"""The OpenAPI document is valid and complete, and agrees with the server."""

import json
import re
from typing import Any

import httpx
import pytest
from openapi_schema_validator import OAS31Validator
from openapi_spec_validator import OpenAPIV31SpecValidator

from plinko.app.main import create_app
from plinko.app.settings import Settings
from plinko.app.web.routes.common import components
from plinko.app.web.schemas.drops import DropRecord
from plinko.engine import Board, BoardError, Label, drop
from tests.app.conftest import TINY
from tests.kit.presets import SAMPLE


@pytest.fixture(scope="module")
def document(http: httpx.Client) -> dict[str, Any]:
    response = http.get("/openapi.json")
    assert response.status_code == 200
    found: dict[str, Any] = response.json()
    return found


def operations(document: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    return [
        (path, method, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    ]


INTERFACE = """
/api/v1/announcement post
/api/v1/bans post
/api/v1/boards get post
/api/v1/boards/check post
/api/v1/boards/{board} get
/api/v1/boards/{board}/density.{format} get
/api/v1/boards/{board}/histogram.{format} get
/api/v1/boards/{board}/odds get
/api/v1/boards/{board}/sheet.{format} get
/api/v1/drops post
/api/v1/drops/{board}/{seed} get
/api/v1/drops/{board}/{seed}.{format} get
/api/v1/drops/{board}/{seed}/frames get
/api/v1/halts get post
/api/v1/log get
/api/v1/payouts post
/api/v1/players/{key} delete
/api/v1/players/{key}/plays get
/api/v1/rooms get post
/api/v1/rooms/{room} delete get patch
/api/v1/rooms/{room}/best get
/api/v1/rooms/{room}/draw get
/api/v1/rooms/{room}/drops post
/api/v1/rooms/{room}/frame.{format} get
/api/v1/rooms/{room}/log get
/api/v1/rooms/{room}/move post
/api/v1/rooms/{room}/plays get
/api/v1/rooms/{room}/qr.svg get
/api/v1/rooms/{room}/queue get patch post
/api/v1/rooms/{room}/queue/clear post
/api/v1/rooms/{room}/queue/skip post
/api/v1/rooms/{room}/reset post
/api/v1/rooms/{room}/show get put
/api/v1/rooms/{room}/stream.mjpg get
/api/v1/scenes get
/api/v1/seeds post
/api/v1/sessions post
/api/v1/sessions/{session} get
/api/v1/sessions/{session}/end post
/api/v1/sessions/{session}/export get
/api/v1/sessions/{session}/opening post
/api/v1/simulate post
/api/v1/verify post
/healthz get
/metrics get
/readyz get
"""


def test_it_lists_the_interface_and_is_valid_openapi_3_1(document: dict[str, Any]) -> None:
    found = [" ".join([path, *sorted(methods)]) for path, methods in document["paths"].items()]
    assert sorted(found) == INTERFACE.split("\n")[1:-1]
    assert document["openapi"].startswith("3.1")
    assert [str(error) for error in OpenAPIV31SpecValidator(document).iter_errors()] == []


def test_operations_have_names_that_one_would_write(document: dict[str, Any]) -> None:
    names = [operation["operationId"] for _, _, operation in operations(document)]
    assert len(names) == len(set(names))
    assert [name for name in names if not re.fullmatch(r"[a-z]+(_[a-z][a-z0-9]*)*", name)] == []
    assert {"list_boards", "get_drop", "get_drop_picture", "drop_into_room"} <= {*names}


def board_validator() -> OAS31Validator:
    return OAS31Validator(
        {"$ref": "#/components/schemas/BoardForm", "components": {"schemas": components()}}
    )


def test_the_boards_schema_describes_every_preset_and_has_the_server_s_defaults() -> None:
    """A board without optional fields equals a board with the schema's defaults."""
    validator = board_validator()
    for name in SAMPLE:
        assert [str(error) for error in validator.iter_errors(Board.preset(name).to_dict())] == []

    def filled(name: str) -> dict[str, Any]:
        result = {}
        for key, schema in components()[name]["properties"].items():
            if "default" in schema:
                result[key] = schema["default"]
            elif "$ref" in schema:
                result[key] = filled(schema["$ref"].rpartition("/")[2])
        return result

    assert Board.from_json(filled("BoardForm")) == Board.from_json({})


@pytest.mark.parametrize(
    ("path", "bad"),
    [
        (("gravty",), 9.81),
        (("gravity",), 0.0),
        (("drag",), -0.1),
        (("name",), ""),
        (("ball", "radius"), 0.0),
        (("ball", "restitution"), 1.1),
        (("ball", "density"), "heavy"),
        (("pegs",), [{"x": 0.0, "y": 1.0}]),
        (("bins", "edges"), [0.0]),
        (("bins", "multipliers"), [-1.0, 1.0]),
        (("drop", "jitter"), -1.0),
        (("peg_material", "friction"), 11.0),
    ],
)
def test_what_the_boards_schema_refuses_the_server_refuses(path: tuple[str, ...], bad: Any) -> None:
    form = json.loads(json.dumps(TINY))
    assert board_validator().is_valid(form)
    place = form
    for key in path[:-1]:
        place = place.setdefault(key, {})
    place[path[-1]] = bad
    assert not board_validator().is_valid(form)
    with pytest.raises(BoardError):
        Board.from_json(form)


def test_every_operation_reads_well_and_fails_with_problem_details(
    document: dict[str, Any],
) -> None:
    tags = {tag["name"] for tag in document["tags"]}
    for path, method, operation in operations(document):
        assert operation["summary"], path
        assert operation["description"], path
        assert set(operation["tags"]) <= tags, path
        assert operation["tags"], path
        if method in ("post", "patch") and not path.endswith(("/reset", "/end", "/skip", "/clear")):
            assert "application/json" in operation["requestBody"]["content"], path
        success = next(code for code in operation["responses"] if code.startswith("2"))
        if success != "204":
            contents = operation["responses"][success]["content"]
            if path.endswith("/plays"):
                assert [*contents] == ["application/json", "text/csv"], path
            else:
                assert len(contents) == 1 or path.endswith(".{format}"), path
            assert all(content["schema"] for content in contents.values()), path
        for code, response in operation["responses"].items():
            if int(code) >= 400 and path != "/readyz":  # its 503 lists its checks
                schema = response["content"]["application/problem+json"]["schema"]
                assert schema == {"$ref": "#/components/schemas/Problem"}, path
        limit = operation["responses"]["429"]
        assert {"Retry-After", "RateLimit", "RateLimit-Policy"} <= set(limit["headers"]), path
        assert ("415" in operation["responses"]) == ("requestBody" in operation), (path, method)


def test_a_token_is_optional_where_the_public_may_do_without(document: dict[str, Any]) -> None:
    optional = {
        operation["operationId"]
        for _, _, operation in operations(document)
        if {} in operation.get("security", ())
    }
    assert optional == {"drop_into_room", "begin_session", "get_room_log"}
    # A picture is one operation with a format.
    operation = document["paths"]["/api/v1/drops/{board}/{seed}.{format}"]["get"]
    (chosen,) = (each for each in operation["parameters"] if each["name"] == "format")
    assert chosen["schema"]["enum"] == ["png", "jpg", "gif", "webp", "apng", "mp4"]


@pytest.mark.parametrize("root_path", ["", "/games/plinko"])
def test_it_names_the_server(root_path: str) -> None:
    document = create_app(Settings(database_url="sqlite://", root_path=root_path)).openapi()
    assert document["servers"] == [{"url": root_path or "/"}]


def test_every_reference_resolves_and_every_schema_is_described(
    document: dict[str, Any],
) -> None:
    known = document["components"]["schemas"]
    # One schema for all items of an array; older drafts used a list of schemas.
    assert not re.search(r"'items': \[|prefixItems", str(known))
    for name in re.findall(r"#/components/schemas/(\w+)", str(document)):
        assert name in known
    for name, schema in known.items():
        assert schema.get("description"), name


def test_a_record_has_exactly_the_fields_that_are_documented() -> None:
    board = Board.preset("triangle-8")
    fields = set(DropRecord.__struct_fields__)
    exact = drop(board, 42).to_dict()
    sure = drop(board, 42).to_dict(certainty=True)
    stepped = drop(board, 42, x=0.0, solver="stepped").to_dict()
    aimed = drop(board, 42, aim=0.0).to_dict()
    prizes = drop(board.replace(bins={"labels": [Label("prize")] * 9}), 42).to_dict()
    assert set(sure) | set(stepped) | set(aimed) | set(prizes) | {"certificate"} == fields
    required = set(components()["DropRecord"]["required"])
    assert required == set(exact)
