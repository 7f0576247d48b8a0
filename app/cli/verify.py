"""`plinko verify`: compute a recorded drop, or a whole room, again and say if it is the same."""

import json
import sys
from pathlib import Path
from typing import Any

import click

EXIT_DIFFERS = 1


@click.command(name="verify", short_help="Compute a recorded drop or room again and compare.")
@click.argument("record", metavar="RECORD.json")
def command(record: str) -> int:
    """Compute what RECORD.json tells of again and compare every field and digest.

    RECORD.json is what `plinko drop --json` printed, or a room's log (GET rooms/{id}/log), of which
    every drop is replayed at its tick; - reads it from standard input. Exit code 0: reproduced;
    1: not, and which field differs; 2: not a record.
    """
    fields = _read(record)

    from app.rooms import log

    if log.is_log(fields):
        result = log.verify_log(fields)
        name = "drop" if "drops" in fields else "input"
        count = len(fields[f"{name}s"])
        what, maker, done = "log", "replay", f"{count} {name}{'s' * (count != 1)}, "
    else:
        from engine import verify

        result = verify(fields)
        what, maker, done = "record", "drop", ""
    if result.ok:
        click.echo(f"reproduced: {done}{fields['digest']}")
        return 0
    click.echo(
        f"not reproduced: {result.field} differs: "
        f"the {what} says {_short(result.expected)}, the {maker} gives {_short(result.actual)}"
    )
    return EXIT_DIFFERS


def _read(name: str) -> dict[str, Any]:
    """The JSON object in the file `name`, or on standard input for `-`."""
    from engine.errors import RecordError

    raw = sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    try:
        fields = json.loads(raw)
    except RecursionError:
        raise RecordError(f"{name}: nested too deeply to be a record") from None
    except ValueError as error:  # not JSON, or not UTF-8
        raise RecordError(f"{name}: not JSON: {error}") from None
    if not isinstance(fields, dict):
        raise RecordError(f"{name}: a record is one JSON object, not {_short(fields)}")
    return fields


def _short(value: object) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 80 else text[:77] + "..."
