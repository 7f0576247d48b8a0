"""`plinko verify`: recompute a drop, a room or a fair session and compare with its record."""

import functools
import json
import sys

import click

from plinko.app.cli import common
from plinko.engine.json_text import JsonObject

EXIT_DIFFERS = 1


@click.command(name="verify", short_help="Recompute a recorded drop or room and compare.")
@click.argument("record", metavar="RECORD.json")
@click.option("--key", help="The public key that the session's server must have (hexadecimal).")
@click.option(
    "--heard",
    multiple=True,
    metavar="REPLY.json",
    help="A reply that the player kept, to POST sessions or to a drop; repeatable.",
)
def command(record: str, key: str | None, heard: tuple[str, ...]) -> int:
    """Recompute the record in RECORD.json and compare every field and digest.

    A record is the output of `plinko drop --json`, a room's log (GET rooms/{id}/log), or the
    export of a fair session (GET sessions/{id}/export). - reads it from standard input. Exit code
    0: reproduced; 1: a field or step differs, which the output names; 2: not a record.

    --heard proves that the server was bound before it knew the player's secret: the export must
    agree with replies that the player kept.
    """
    fields = _read(record)
    replies = [_read(reply) for reply in heard]

    from plinko.app.fairness.export import is_export, with_heard
    from plinko.app.rooms import log

    if is_export(fields):
        return _session(functools.reduce(with_heard, replies, fields), key)
    if replies:
        raise click.UsageError(f"--heard needs the export of a fair session, which {record} is not")
    if log.is_log(fields):
        result = log.verify_log(fields)
        name = "drop" if "drops" in fields else "input"
        what, maker, done = "log", "replay", f"{common.counted(len(fields[f'{name}s']), name)}, "
    else:
        from plinko.engine import verify

        result = verify(fields)
        what, maker, done = "record", "drop", ""
    if result.ok:
        common.echo(f"reproduced: {done}{fields['digest']}")
        return 0
    common.echo(
        f"not reproduced: {result.field} differs: "
        f"the {what} says {_short(result.expected)}, the {maker} gives {_short(result.actual)}"
    )
    return EXIT_DIFFERS


def _session(fields: JsonObject, key: str | None) -> int:
    """Check a fair session's export and print each step that fails."""
    from plinko.app.fairness.check import check_session, kernel_digest_of
    from plinko.app.fairness.export import read_export
    from plinko.app.settings import page_kernels

    kernel = kernel_digest_of(page_kernels().read_bytes())
    export = read_export(fields)
    verdict = check_session(export, kernel_digest=kernel, key=key)
    for step in verdict.failed:
        where = "" if step.drop is None else f" of drop {step.drop}"
        common.echo(
            f"not proven: {step.name}{where}: {step.text}: "
            f"the session says {_short(step.said)}, found {_short(step.found)}"
        )
    if not verdict.ok:
        return EXIT_DIFFERS
    common.echo(
        f"proven: {common.counted(verdict.drops, 'drop')}, {len(verdict.steps)} steps: each start "
        "comes from both secrets, no drop is missing, each path and payout is correct "
        f"(key {verdict.key})"
    )
    if export.heard_session is None:
        common.echo(
            "not proven: that the server committed before it knew the player's secret; to prove "
            "it, give the reply to POST sessions: --heard REPLY.json"
        )
    else:
        common.echo("proven: the server had committed before: neither side could choose a start")
    common.echo("not proven: that an account has the stakes and payouts, or whose key this is")
    return 0


def _read(name: str) -> JsonObject:
    """The JSON object in the file `name`, or on standard input for `-`."""
    from plinko.engine import json_text
    from plinko.engine.errors import JsonSyntaxError, JsonValueError, RecordError

    try:
        fields = json_text.parse(json_text.read_text(sys.stdin.buffer if name == "-" else name))
    except (JsonSyntaxError, JsonValueError) as error:
        raise RecordError(f"{name}: {error}") from None
    if not isinstance(fields, dict):
        raise RecordError(f"{name}: {_short(fields)} is not a record, which is one JSON object")
    return fields


def _short(value: object) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 80 else text[:77] + "..."
