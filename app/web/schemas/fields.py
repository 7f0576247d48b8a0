"""Fields that several bodies share: boards, seeds, starts and digests, with their descriptions.

Seeds, boards and starts have parsers with better error messages than msgspec's. They are therefore
`Json` or `Raw` here; the description and the JSON schema say which values are valid.
"""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from plinko.app.protocol.visitors import MAX_NAME
from plinko.engine.json_text import Json

_BOARD_FORM = {"$ref": "#/components/schemas/BoardForm"}
_NAMED_BOARD = "A preset's name, the digest of a registered board, or a whole board."

_A_BOARD = Meta(
    description=_NAMED_BOARD,
    examples=["triangle-16"],
    extra_json_schema={"anyOf": [{"type": "string"}, _BOARD_FORM]},
)
BoardRef = Annotated[Json, _A_BOARD]
# Raw, because a worker parses it: a board of 5,000 pegs would block the event loop for 3 ms.
BoardIn = Annotated[msgspec.Raw, _A_BOARD]
OptionalBoard = Annotated[
    msgspec.Raw,
    Meta(
        description=_NAMED_BOARD,
        examples=["triangle-16"],
        extra_json_schema={
            "anyOf": [{"type": "string"}, _BOARD_FORM, {"type": "null"}],
            "default": None,
        },
    ),
]
WholeBoard = Annotated[Json, Meta(extra_json_schema=_BOARD_FORM)]
SeedIn = Annotated[
    Json,
    Meta(
        description="0 <= seed < 2^64, as a decimal string or an integer; default: the server "
        "draws one.",
        examples=["42"],
        extra_json_schema={"anyOf": [{"type": "string"}, {"type": "integer"}, {"type": "null"}]},
    ),
]
AimIn = Annotated[
    Json,
    Meta(
        description="Middle of the starts that seeds draw, in metres; default: the board's own.",
        examples=[0.01],
        extra_json_schema={"anyOf": [{"type": "number"}, {"type": "null"}]},
    ),
]
NameIn = Annotated[
    Json,
    Meta(
        description="The name shown at the ball. In a room with an owner it needs the room's "
        "token.",
        examples=["Ada"],
        extra_json_schema={
            "anyOf": [{"type": "string", "minLength": 1, "maxLength": MAX_NAME}, {"type": "null"}]
        },
    ),
]
ColourIn = Annotated[
    Json,
    Meta(
        description="The ball's colour. In a room with an owner it needs the room's token.",
        examples=["#e91e63"],
        extra_json_schema={
            "anyOf": [{"type": "string", "pattern": "^#[0-9a-f]{6}$"}, {"type": "null"}]
        },
    ),
]
StartIn = Annotated[
    Json,
    Meta(
        description="Explicit start in metres; default: drawn from the seed.",
        examples=[0.1],
        extra_json_schema={"anyOf": [{"type": "number"}, {"type": "null"}]},
    ),
]
Seed = Annotated[str, Meta(description="The seed, as a decimal string.", examples=["42"])]
Digest = Annotated[
    str, Meta(description="SHA-256, 64 hexadecimal digits.", pattern="^[0-9a-f]{64}$")
]
PhysicsVersion = Annotated[
    Json,
    Meta(
        description="Digests are comparable only if they have the same physics version.",
        extra_json_schema={"anyOf": [{"type": "integer"}, {"type": "string"}]},
    ),
]
Solver = Annotated[
    Literal["exact", "stepped"],
    Meta(description="`exact`: event-driven, no stepping error. `stepped`: fixed steps of `dt`."),
]
