"""`plinko certify`: one seeded drop whose bin is proven."""

from typing import TYPE_CHECKING

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.engine import Certificate


@click.command(name="certify", short_help="Prove where one ball lands.")
@common.board_argument
@common.seed_option
@click.option("--x", help="Start here (metres), exactly: 0.1 is one tenth; 1/3 works too.")
@common.aim_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(board: str, seed: str | None, x: str | None, aim: float | None, as_json: bool) -> None:
    """Prove in which bin of BOARD a ball lands that starts at --seed or --x.

    This computes the laws of the exact solver in ball arithmetic. Enclosures decide every
    comparison; the precision doubles until all are decided. The bin is then a theorem about the
    numbers of the board. Exit code 1: undecided at the highest precision.
    """
    if (seed is None) == (x is None):
        raise click.UsageError("give a start: either --seed N or --x X")
    common.need_certifier()
    from plinko.app.computing.tasks import proof_effort
    from plinko.engine import certify

    found = certify(common.load_board(board), seed, x=x, aim=aim, effort=proof_effort())
    if as_json:
        head = {"board": found.board.preset_name or found.board.to_dict()}
        start = {"seed": None if found.seed is None else str(found.seed)}
        common.print_json(head | {"board_digest": found.board.digest} | start | found.to_dict())
    else:
        common.print_fields(_fields(found))
    if not found.decided:
        raise SystemExit(1)


def _fields(found: "Certificate") -> dict[str, str]:
    fields = {
        "board": found.board.name,
        "seed": "none" if found.seed is None else str(found.seed),
        "start": f"x = {found.x_start} m",
        "bin": _bin(found),
    }
    if found.x_end is not None and found.duration is not None:
        fields["end"] = f"x = {found.x_end.text} m"
        fields["time"] = f"{found.duration.text} s"
    fields["impacts"] = str(found.impacts)
    fields["proof"] = f"{found.comparisons} comparisons decided with {found.bits} bits"
    if found.ties:
        fields["ties"] = "; ".join(found.ties)
    if found.agrees is not None:
        other = "none" if found.double_bin is None else str(found.double_bin)
        fields["double precision"] = f"bin {other}: {'right' if found.agrees else 'wrong'}"
    return fields


def _bin(found: "Certificate") -> str:
    if found.undecided is not None:
        return f"undecided: {found.undecided}"
    if found.bin is None:
        return f"none, proven: {found.unsettled}"
    return f"{found.bin} of 0 to {found.board.bins.count - 1}, proven"
