"""A single server starts no cluster; a cluster's server without its settings says which."""

import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from click.testing import CliRunner

from plinko.app.cli import plinko
from plinko.app.errors import SettingError
from plinko.app.main import create_app
from plinko.app.settings import Settings
from tests.kit.serving import Running

_IMPORTED = """
import sys
from plinko.app.main import create_app
from plinko.app.settings import Settings
app = create_app(Settings(database_url="sqlite://"))
names = {name.partition(".")[0] for name in sys.modules}
needed = sorted(names & {"psycopg", "redis", "httpx"})
print(needed, "plinko.app.cluster" in sys.modules, app.state.cluster)
"""


def test_a_server_alone_imports_nothing_of_a_cluster() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _IMPORTED], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["[]", "False", "None"]


def test_a_server_alone_moves_no_rooms_and_says_so(http: httpx.Client, server: Running) -> None:
    assert server.services.others is None
    answer = http.post("/api/v1/rooms/main/move", json={"to": "b"})
    assert answer.status_code == 403, "and this one has no operator at all"
    assert http.get("/readyz").json()["cluster"] is None
    assert "plinko_cluster" not in http.get("/metrics").text


def test_a_name_is_for_servers_that_share_a_ledger_on_postgresql(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"use a ledger on PostgreSQL, or omit --name"):
        create_app(Settings(name="a", data=str(tmp_path)))


def test_only_the_operator_s_token_moves_rooms(server: Running) -> None:
    done = CliRunner().invoke(plinko, ["rooms", "move", "main", "b", server.url])
    assert isinstance(done.exception, SettingError)
    assert "PLINKO_OPERATOR_TOKEN" in str(done.exception)
