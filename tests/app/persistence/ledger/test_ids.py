"""An id with a NUL character, which PostgreSQL cannot store, is not found on either database."""

from tests.kit.serving import serving

NUL = "%00"


def test_whatever_has_a_nul_in_its_id_is_not_found(url: str) -> None:
    with serving(database_url=url) as server, server.client() as http:
        for path in (
            f"rooms/{NUL}",
            f"rooms/main{NUL}",
            f"rooms/{NUL}/log",
            f"rooms/{NUL}/frame.png",
            f"boards/{NUL}",
            f"boards/{NUL}/odds",
            f"drops/{NUL}/1",
            f"sessions/{NUL}",
            f"sessions/a{NUL}b",
        ):
            answer = http.get(f"/api/v1/{path}")
            assert (path, answer.status_code) == (path, 404), answer.text
        begun = http.post("/api/v1/sessions", json={"room": "\0", "commitment": "00" * 32})
        assert begun.status_code == 404, begun.text
        assert http.get("/readyz").status_code == 200, "the ledger was not taken for lost"
