"""`plinko seeds`: find seeds that land in one bin, or make a draw with exact odds for all bins."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from plinko.app.batches.files import write_whole
from plinko.app.cli import common
from plinko.engine import json_text

if TYPE_CHECKING:
    from plinko.engine import Board


@click.command(name="seeds", short_help="Find seeds that land in a bin.")
@common.board_argument
@click.option("--bin", "number", type=int, help="The bin's number from the left, from 0.")
@click.option(
    "--draw",
    metavar="WEIGHTS",
    help="Instead of --bin: make a draw. One weight per bin, such as 9999,1, or a JSON file.",
)
@click.option("--count", type=common.COUNT, default=1, help="How many seeds.")
@click.option(
    "--per-bin", type=common.COUNT, default=100, help="For --draw: seeds per bin with a weight."
)
@click.option(
    "-o", "--output", type=common.OUT, help="For --draw: the file to write. [standard output]"
)
@click.option("--after", metavar="SEED", help="Begin with the seed after this one. [from 0 on]")
@common.aim_option
@click.option(
    "--patience",
    type=common.COUNT,
    help="Give up after this many seeds in a row that land elsewhere. [10,000,000]",
)
@common.threads_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    number: int | None,
    draw: str | None,
    count: int,
    per_bin: int,
    output: Path | None,
    after: str | None,
    aim: float | None,
    patience: int | None,
    threads: int | None,
    as_json: bool,
) -> None:
    """Print the next seeds whose balls land in a bin of BOARD, in rising order.

    The command drops one seed after the other and skips none. The flight is physics: `plinko drop`
    with such a seed lands in the same bin.

    With --draw it writes the body of a `POST rooms` request, for a room in which each bin has
    exactly the odds of its weight: the server draws a bin, then one of that bin's seeds.
    """
    from plinko.engine import find_draw, seeds_landing_in
    from plinko.engine.drops.seeds import PATIENCE

    if (number is None) == (draw is None):
        raise click.UsageError("give either --bin or --draw")
    found = common.load_board(board)
    begin = None if after is None else common.read_seed(after)
    how: dict[str, Any] = {
        "after": begin, "patience": patience or PATIENCE, "threads": threads
    }  # fmt: skip
    if draw is not None:
        if aim is not None:
            raise click.UsageError(f"--aim {aim:g}: a draw has no aim; give --draw without --aim")
        _write_draw(found, find_draw(found, _weights(draw), per_bin=per_bin, **how), output)
        return
    assert number is not None
    seeds = seeds_landing_in(found, number, count=count, aim=aim, **how)
    if as_json:
        listed = [str(seed) for seed in seeds]
        common.print_json({"board_digest": found.digest, "bin": number, "seeds": listed})
        return
    for seed in seeds:
        common.echo(seed)


def _weights(text: str) -> Any:
    """Parse `9999,1`, or read the JSON file at this path; `find_draw` checks the result."""
    numbers = text.split(",")
    try:
        if all(number.strip().isdecimal() for number in numbers):
            return [int(number) for number in numbers]
        return json_text.parse(json_text.read_text(text))
    except (OSError, ValueError) as error:
        raise click.UsageError(
            f"--draw {text!r} is neither a list of weights such as 9999,1 nor a JSON file with "
            f"such a list: {error}"
        ) from error


def _write_draw(board: "Board", draw: dict[str, Any], output: Path | None) -> None:
    body = {"board": board.preset_name or board.to_dict(), "mode": "draw", "draw": draw}
    text = json.dumps(body) + "\n"
    if output is None:
        common.echo(text, nl=False)
        return
    write_whole(output, text.encode())
    count = sum(map(len, draw["seeds"]))
    common.echo(f"{output}: {common.counted(count, 'seed')}, ready for POST rooms")
