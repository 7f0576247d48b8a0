"""Valid and invalid requests for each REST operation, generated from the OpenAPI document.

Only the test that uses it imports this module: Schemathesis takes half a second to import.
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
"""Requests for each operation of the REST interface."""

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]

WRONG = (AssertionError, FailureGroup, Failure)
"""The errors that `ask` raises if an answer contradicts the OpenAPI document."""


def operations_of(document: str) -> list[Any]:
    """Every operation of an OpenAPI document, except endless streams."""
    schema = schemathesis.openapi.from_url(document)
    operations: Any = schema.exclude(path_regex=r"mjpg").get_all_operations()
    return [result.ok() for result in operations]


def ask(operation: Any, room: dict[str, Any]) -> None:
    """Send many requests for one operation; raises an error of WRONG for a wrong answer.

    Half of the requests name existing things and have the token of the room's owner.
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
