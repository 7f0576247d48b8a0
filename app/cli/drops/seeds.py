"""`plinko seeds`: the seeds whose balls land in one bin."""

import click

from app.cli import common


@click.command(name="seeds", short_help="Find seeds that land in a bin.")
@common.board_argument
@click.option("--bin", "number", type=int, required=True, help="Its number from the left, from 0.")
@click.option("--count", type=click.IntRange(min=1), default=1, show_default=True, help="How many.")
@click.option("--after", metavar="SEED", help="Begin with the seed after this one. [from 0 on]")
@common.aim_option
@click.option(
    "--patience",
    type=click.IntRange(min=1),
    help="Give up after this many seeds in a row that land elsewhere. [10,000,000]",
)
@click.option("--threads", type=click.IntRange(min=1), help="Default: every core.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    number: int,
    count: int,
    after: str | None,
    aim: float | None,
    patience: int | None,
    threads: int | None,
    as_json: bool,
) -> None:
    """Print the next seeds whose balls land in a bin of BOARD, in rising order, none left out.

    They are found by dropping one seed after the other: nothing steers a ball, and each of these
    would have landed there anyway, as `plinko drop` shows.
    """
    from engine.drops.seeds import PATIENCE, seeds_landing_in

    found = common.load_board(board)
    begin = None if after is None else common.read_seed(after)
    seeds = seeds_landing_in(
        found,
        number,
        after=begin,
        count=count,
        aim=aim,
        patience=patience or PATIENCE,
        threads=threads,
    )
    if as_json:
        listed = [str(seed) for seed in seeds]
        common.print_json({"board_digest": found.digest, "bin": number, "seeds": listed})
        return
    for seed in seeds:
        click.echo(seed)
