"""Requests of each operation of the REST interface, good and bad, by its own description.

Imported by the one test that asks them: Schemathesis takes half a second to import.
"""

from typing import Any

import schemathesis
from hypothesis import HealthCheck, given, settings
from schemathesis import GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.core.failures import Failure, FailureGroup
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from tests.long import tries

EXAMPLES = tries(2, 300)
"""Requests of each operation of the REST interface."""

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]

WRONG = (AssertionError, FailureGroup, Failure)
"""What `ask` raises of an answer that was not promised."""


def operations_of(document: str) -> list[Any]:
    """Every operation of the OpenAPI document at an address, but those that never end."""
    schema = schemathesis.openapi.from_url(document)
    operations: Any = schema.exclude(path_regex=r"mjpg").get_all_operations()
    return [result.ok() for result in operations]


def ask(operation: Any, room: dict[str, Any]) -> None:
    """Ask for one operation in many ways; raises what is wrong with an answer.

    Half of the requests are about things that there are, and come from the room's creator.
    """
    good = operation.as_strategy(generation_mode=GenerationMode.POSITIVE)
    bad = operation.as_strategy(generation_mode=GenerationMode.NEGATIVE)
    real = {"board": "triangle-8", "seed": "42", "room": room["id"]}

    @given(case=good | bad if operation.path_parameters or operation.body else good, known=...)
    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    def answered(case: Any, known: bool) -> None:
        headers = {}
        if known:
            case.path_parameters.update({k: v for k, v in real.items() if k in case.path})
            headers = {"authorization": f"Bearer {room['token']}"}
        case.call_and_validate(checks=CHECKS, timeout=60, headers=headers)

    answered()
