"""A room can be closed and begun anew at once, unless what falls in it falls for very long."""

import httpx
import pytest

from app.computing import prices
from benchmarks.scenes.expensive_boards import hall
from tests.kit.serving import constants, serving


@pytest.mark.parametrize("how", ["close", "reset"])
def test_after_an_endless_bounce_a_room_goes_on_its_owner_pays(
    how: str,
) -> None:
    little = {"app.main.COMPUTE_BURST": 0.1 * prices.UNSETTLED}
    with (
        constants(**little),
        serving() as server,
        server.client("/api/v1") as http,
    ):
        made = http.post("/rooms", json={"board": hall()}).raise_for_status().json()
        bearer = {"authorization": f"Bearer {made['token']}"}
        room = f"/rooms/{made['id']}"

        def drop() -> None:
            # One seed in ten lands, some of them soon. This one bounces for 15 minutes.
            body = {"seed": "0"}
            http.post(f"{room}/drops", json=body, headers=bearer).raise_for_status()

        def end() -> httpx.Response:
            if how == "close":
                return http.delete(room, headers=bearer)
            return http.post(f"{room}/reset", headers=bearer)

        drop()
        tried = [end(), end()]  # the first leaves a debt that takes seconds to go
        assert [each.status_code for each in tried] == [503, 429]
        assert tried[0].json()["code"] == "busy"
        assert "retry-after" in tried[0].headers
        assert http.get(room).json()["awake"], "nothing has become of the ball"
        drop()
