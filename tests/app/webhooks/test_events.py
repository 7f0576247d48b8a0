"""The events sent to a webhook's target, and their signature."""

import base64
from typing import Any

from plinko.app.webhooks.sender import event_of, signed

ROW: dict[str, Any] = {
    "number": 9, "target": "http://example.org", "room": 3, "ball": 7, "event": "accepted",
    "room_id": "show", "board": "d1", "tick": 60, "seed": "18446744073709551615", "x": None,
    "stake": 100, "who": None, "aim": None, "practice": False, "key": "secret",
}  # fmt: skip
RESULT: dict[str, Any] = {
    "result_room": 3, "result_ball": 7, "result_tick": 240, "result_bin": 1, "result_score": 2.0,
    "result_t": 3.0, "result_x_end": 0.1, "result_digest": "ab", "result_unsettled": None,
    "result_payout": 200,
}  # fmt: skip


def test_the_signature_is_that_of_the_standard_s_example() -> None:
    # https://docs.svix.com/receiving/verifying-payloads/how-manual
    key = base64.b64decode("MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    headers = signed(key, "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}')
    assert headers["webhook-signature"] == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="
    assert headers["webhook-timestamp"] == "1614265330"
    assert headers["webhook-id"] == "msg_p5jXN8AQM9LWM0D4loKWxJek"


def test_an_accepted_drop_has_its_own_id_and_no_client_s_key() -> None:
    assert event_of(ROW, ()) == {
        "id": "3.7.accepted", "type": "accepted", "room": "show", "run": 3, "ball": 7,
        "board": "d1", "tick": 60, "seed": "18446744073709551615", "x": None, "stake": 100,
    }  # fmt: skip


def test_a_landing_has_the_result_and_the_prize() -> None:
    told = event_of({**ROW, **RESULT, "event": "landed", "practice": True}, (None, "Teapot"))
    assert told["id"] == "3.7.landed"
    assert told["label"] == "Teapot"
    assert (told["tick"], told["bin"], told["payout"], told["digest"]) == (240, 1, 200, "ab")
    assert told["practice"] is True


def test_a_ball_that_ends_in_no_bin_has_no_prize() -> None:
    assert "label" not in event_of(
        {**ROW, **RESULT, "event": "landed", "result_bin": None}, (None, "Teapot")
    )
