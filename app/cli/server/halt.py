"""`plinko halt`: stop the rooms of a running server from accepting drops, or release them."""

import json
import os
import urllib.error
import urllib.parse
import urllib.request

import click

from plinko.app.cli import common
from plinko.app.errors import SettingError
from plinko.engine.json_text import JsonObject

TOKEN = "PLINKO_OPERATOR_TOKEN"

PATIENCE = 30.0
"""Seconds to wait for an answer: longer than a server takes to move a room."""


@click.command(name="halt", short_help="Halt a server's tables, or release them.")
@click.argument("url")
@click.option("--room", help="The table's id.  [all tables]")
@click.option("--release", is_flag=True, help="End the halt.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(url: str, room: str | None, release: bool, as_json: bool) -> None:
    """Halt the tables of the server at URL: no new drops; balls in flight land and are paid.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with. A
    halt survives restarts of the server; only --release ends it.
    """
    found = ask(url, "/api/v1/halts", {"room": room, "halted": not release})
    if as_json:
        common.print_json(found)
        return
    rooms = ", ".join(each["room"] for each in found["rooms"])
    common.print_fields(
        {
            "all tables": "halted" if found["all_since"] else "not halted",
            "halted individually": rooms or "none",
        }
    )


def ask(url: str, path: str, body: dict[str, object] | None, method: str = "POST") -> JsonObject:
    """Send `body` to the server at `url` and return its answer; raises SettingError on failure."""
    address = urllib.parse.urlsplit(url)
    if address.scheme not in ("http", "https") or not address.netloc:
        raise SettingError(f"{url!r} is not an address such as http://127.0.0.1:8000", field="url")
    headers = {"content-type": "application/json"}
    if token := os.environ.get(TOKEN):
        headers["authorization"] = f"Bearer {token}"
    asked = urllib.request.Request(
        f"{url.rstrip('/')}{path}", json.dumps(body or {}).encode(), headers, method=method
    )
    try:
        with urllib.request.urlopen(asked, timeout=PATIENCE) as answer:
            if answer.status == 204:
                return {}
            return _document(url, answer.status, answer.read())
    except urllib.error.HTTPError as refused:
        said = _document(url, refused.code, refused.read())
        raise SettingError(f"{url}: {said.get('detail', refused.code)}", field="url") from refused
    except OSError as missing:
        why = getattr(missing, "reason", missing)
        raise SettingError(f"{url}: {why}", field="url") from missing


def _document(url: str, status: int, body: bytes) -> JsonObject:
    """Parse an answer; raises SettingError if another program, such as a proxy, gave it."""
    try:
        found = json.loads(body)
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise SettingError(
            f"{url} is not a Plinko server: it answered {status} without a JSON object",
            field="url",
        )
    return found
