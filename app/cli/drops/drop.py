"""`plinko drop`: compute one drop and print it as text or JSON."""

from typing import TYPE_CHECKING

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.engine import Drop

HALF_DIGIT = 5e-7
"""Half of the last printed digit of a length, m."""


@click.command(name="drop", short_help="Drop one ball and say where it lands.")
@common.board_argument
@common.seed_option
@common.x_option
@common.aim_option
@common.solver_options
@click.option("--certainty", is_flag=True, help="Also say whether rounding may decide the bin.")
@click.option("--json", "as_json", is_flag=True, help="Print the whole record as one JSON object.")
@common.garbage_waits()
def command(
    board: str,
    seed: str | None,
    x: float | None,
    aim: float | None,
    how: common.Options,
    certainty: bool,
    as_json: bool,
) -> None:
    """Drop one ball on BOARD from the start of --seed, or from --x, and say where it lands.

    The same board and seed give the same drop to the last bit on every machine; the digest proves
    it. `plinko verify` checks the output of --json.
    """
    d = common.dropped(board, seed, x, aim, how)
    if as_json:
        common.print_json(d.to_dict(certainty=certainty))
    else:
        sure = _how_sure(d) if certainty else _how_unsure(d)
        common.print_fields(_summary(d) | sure)


def _summary(d: "Drop") -> dict[str, str]:
    bins = d.board.bins
    if d.bin is None:
        result = {"bin": f"none: {d.unsettled}", "score": "1 (the stake back)"}
    else:
        result = {
            "bin": f"{d.bin} of 0 to {bins.count - 1}",
            "score": f"{d.score:g}",
        }
    return {
        "board": d.board.name,
        "seed": "none" if d.seed is None else str(d.seed),
        "solver": common.describe_solver(d.solver),
        "start": f"x = {d.x_start:.6f} m" + ("" if d.aim is None else f", aimed at {d.aim:g} m"),
        **result,
        "end": f"x = {d.x_end:.6f} m after {d.duration:.6f} s",
        "impacts": _impacts(d),
        "digest": d.digest,
    }


def _how_unsure(d: "Drop") -> dict[str, str]:
    """What rounding may have done to the printed values, if anything."""
    if d.solver.name != "exact" or d.bin is None:
        return {}
    sure = _how_sure(d)
    shown = [] if d.certain else ["certain"]
    if (d.certainty.error or 0.0) > HALF_DIGIT:
        shown.append("error")
    return {name: sure[name] for name in shown}


def _how_sure(d: "Drop") -> dict[str, str]:
    if d.amplification is None:
        return {"certain": "no: it did not land"}
    return {
        "certain": "yes" if d.certain else "no: rounding may decide the bin (see `plinko certify`)",
        "error": f"{d.certainty.error:.1e} m of x, estimated",
        "growth": f"{d.amplification:.1e} m per metre of the start",
    }


def _impacts(d: "Drop") -> str:
    """Number of impacts, in all and of each kind: `61 (60 peg, 1 landing)`."""
    import numpy as np

    from plinko.engine.constants import KIND_NAMES

    counts = np.bincount(d.impacts["kind"], minlength=len(KIND_NAMES))
    kinds = ", ".join(f"{n} {name}" for n, name in zip(counts, KIND_NAMES, strict=True) if n)
    return f"{len(d.impacts)} ({kinds})" if kinds else "0"
