"""The AsyncAPI document is valid by the standard's own schema, which npm installs."""

import json
from pathlib import Path

import jsonschema

from plinko.app.protocol.asyncapi import VERSION, document

SPECIFICATIONS = Path(__file__).parents[3] / "node_modules/@asyncapi/specs/schemas"


def test_it_is_valid_asyncapi() -> None:
    specification = json.loads((SPECIFICATIONS / f"{VERSION}-without-$id.json").read_text())
    found = jsonschema.Draft7Validator(specification).iter_errors(document("1"))
    assert [f"{error.json_path}: {error.message[:200]}" for error in found] == []
