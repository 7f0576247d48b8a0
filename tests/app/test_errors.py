"""The error tree: every class has a response, and every response another code."""

import pytest

from plinko.app import errors
from plinko.app.web import problems
from plinko.engine import errors as engine_errors


def tree(root: type[Exception]) -> set[type[Exception]]:
    return {root}.union(*(tree(child) for child in root.__subclasses__()))


# Some errors prevent the start, and servers run no batch on a cluster: no client sees them.
UNSEEN = {
    errors.SettingError,
    errors.StartError,
    errors.LedgerInUseError,
    engine_errors.ClusterError,
}
SEEN = (tree(errors.AppError) | tree(engine_errors.EngineError)) - UNSEEN
RESPONSES = {kind: errors.response_for(kind.__new__(kind)) for kind in SEEN}


def test_every_error_a_client_can_meet_has_its_own_response() -> None:
    server_error = errors.AppError.response
    assert [kind for kind in SEEN if RESPONSES[kind] == server_error] == [errors.AppError]


def test_each_error_has_its_own_code() -> None:
    # The engine's errors about a text or a value share the code of the server's.
    same: dict[type[Exception], type[Exception]] = {
        engine_errors.EngineError: errors.InvalidValueError,
        engine_errors.JsonValueError: errors.InvalidValueError,
        engine_errors.JsonSyntaxError: errors.MalformedError,
    }
    for kind, other in same.items():
        assert RESPONSES[kind] == RESPONSES[other]
    codes = [response.code for kind, response in RESPONSES.items() if kind not in same]
    assert len(codes) == len(set(codes))
    # Close codes are ones that an application may send.
    standard = {1007, 1008, 1009, 1011, 1012, 1013}
    for response in RESPONSES.values():
        assert response.close in standard or 4000 <= response.close < 5000


def test_a_stranger_is_a_500_whose_message_stays_inside() -> None:
    problem = problems.problem_of(RuntimeError("secret"), "/x")
    assert problem.status == 500
    assert "secret" not in problem.detail


@pytest.mark.parametrize(
    ("error", "seconds"),
    [
        (errors.BusyError("x"), 1),
        (errors.RateLimitError("x", retry_after=0.05), 1),
        (errors.RateLimitError("x", retry_after=2.1), 3),
        (errors.UnknownRoomError("x"), None),
        (engine_errors.SeedError("x"), None),
    ],
)
def test_waiting_is_suggested_where_it_helps(error: Exception, seconds: int | None) -> None:
    assert errors.retry_after(error) == seconds
