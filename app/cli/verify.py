"""`plinko verify`: compute a recorded drop again and say whether it is the same."""

import json
import sys
from pathlib import Path
from typing import Any

import click

EXIT_DIFFERS = 1


@click.command(name="verify", short_help="Compute a recorded drop again and compare.")
@click.argument("record", metavar="RECORD.json")
def command(record: str) -> int:
    """Compute the drop in RECORD.json again and compare every field and the digest.

    RECORD.json is what `plinko drop --json` printed; - reads it from standard input. Exit code 0:
    reproduced; 1: not, and which field differs; 2: not a record.
    """
    fields = _read(record)

    from engine import verify

    result = verify(fields)
    if result.ok:
        click.echo(f"reproduced: {fields['digest']}")
        return 0
    click.echo(
        f"not reproduced: {result.field} differs: "
        f"the record says {_short(result.expected)}, the drop gives {_short(result.actual)}"
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
