"""Commands that ask a running server, with the operator's token: `halt`, `announce`, and others."""

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
def halt(url: str, room: str | None, release: bool, as_json: bool) -> None:
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


@click.command(name="announce", short_help="Show a text to all players of a server.")
@click.argument("text")
@click.argument("url", default="http://127.0.0.1:8000")
def announce(text: str, url: str) -> None:
    """Show TEXT on the pages of all players at the server at URL; an empty text ends it.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """
    found = ask(url, "/api/v1/announcement", {"text": text or None})
    common.print_fields({"announced": found["text"] or "nothing"})


@click.group(name="rooms", short_help="Close a room, or move it to another server.")
def rooms() -> None:
    """Close a room, or move it to another server of a cluster."""


@rooms.command(name="move", short_help="Give a room to another server.")
@click.argument("room")
@click.argument("name")
@click.argument("url", default="http://127.0.0.1:8000")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def move(room: str, name: str, url: str, as_json: bool) -> None:
    """Move ROOM to the server called NAME, which continues it at the same tick.

    URL is any server of the cluster, or the proxy in front of them. PLINKO_OPERATOR_TOKEN in the
    environment must be the token that they were started with.
    """
    path = f"/api/v1/rooms/{urllib.parse.quote(room, safe='')}/move"
    found = ask(url, path, {"to": name})
    if as_json:
        common.print_json(found)
    else:
        common.print_fields({"room": found["room"], "server": found["server"]})


@rooms.command(name="close", short_help="Close a player's room.")
@click.argument("room")
@click.argument("url", default="http://127.0.0.1:8000")
def close(room: str, url: str) -> None:
    """Close ROOM for good: its balls land and are paid, and everyone in it is disconnected.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """
    ask(url, f"/api/v1/rooms/{urllib.parse.quote(room, safe='')}", None, "DELETE")
    common.print_fields({"closed": room})


@click.group(name="players", short_help="Erase or ban a server's players.")
def players() -> None:
    """Erase or ban players of a running server.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """


@players.command(name="erase")
@click.argument("who")
@click.argument("url", default="http://127.0.0.1:8000")
def erase(who: str, url: str) -> None:
    """Take the mark WHO, and names and colours, from all of a player's drops.

    WHO is what the player's page sends as `who`. Drops, results, sums and receipts stay: they say
    nothing of the player.
    """
    path = f"/api/v1/players/{urllib.parse.quote(who, safe='')}"
    common.print_fields({"rows": ask(url, path, None, "DELETE")["rows"]})


@players.command(name="ban")
@click.argument("client")
@click.argument("url", default="http://127.0.0.1:8000")
@click.option("--minutes", default=60, help="For how long; 0 ends the ban.")
def ban(client: str, url: str, minutes: int) -> None:
    """Ban CLIENT for a time: an address from everything, or a player's mark from drops."""
    found = ask(url, "/api/v1/bans", {"client": client, "minutes": minutes})
    common.print_fields({"banned": found["client"], "minutes": found["minutes"]})


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
        raise SettingError(f"{url} cannot be reached: {why}", field="url") from missing


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
