"""Solves the payout tables of a world's triangle, and lets drops of later seeds judge them.

The drops of one sample choose the tables of all risks; as many later ones judge them. If a judged
return is too far from the target, the judges join the sample, and the tables are solved again.
"""

import json
from collections.abc import Mapping
from typing import Final

from plinko.engine.batches.workers import Workers
from plinko.engine.board import presets
from plinko.engine.board.model import Board
from plinko.engine.board.payouts import RISKS, Table
from plinko.engine.payouts.landings import joined, more, none_after, none_yet
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import LEAST_WORLD, Counted
from plinko.engine.payouts.solve import PRECISE_WORLD, needed, table_for

TARGET: Final = 0.99

MOST_OFF: Final = 0.003
"""Largest accepted difference between a judged return and the target."""


def solve_world(name: str, workers: Workers) -> tuple[Counted, dict[str, Table]]:
    """Solve and judge the tables of a world's preset `name`, a variant of medium risk.

    Returns the landings of all drops, and the tables by the names of their presets.
    """
    board = Board.preset(name)
    chose, enough = none_yet(board)[0], LEAST_WORLD
    while True:
        while chose.drops < enough:
            chose = more(board, chose, enough - chose.drops, workers)
            solved = {risk: table_for(board, (chose,), TARGET, risk) for risk in RISKS}
            odds = (odds_of(chose, pays) for pays in solved.values())
            enough = max(needed(each, PRECISE_WORLD) for each in odds)
        judge = more(board, none_after(chose), chose.drops, workers)
        returns = [odds_of(judge, pays).returned for pays in solved.values()]
        if all(abs(each - TARGET) <= MOST_OFF for each in returns):
            break
        chose = joined(chose, judge)
        enough = chose.drops + 1
    variant = presets.VARIANTS[name]
    tables = {}
    for risk, pays in solved.items():
        table = variant._replace(risk=risk).name
        digest = Board.preset(table).replace(bins={"multipliers": pays}).digest
        tables[table] = Table(digest, pays[: variant.rows // 2 + 1])
    return Counted(((chose,), (judge,)), dict.fromkeys(tables, 1)), tables


def to_text(tables: Mapping[str, Table]) -> str:
    """The text of `payouts.json`: a line for each table, in the order of the presets."""
    lines = (
        f" {json.dumps(name)}: {json.dumps([tables[name].digest, tables[name].half])}"
        for name in presets.preset_names()
        if name in tables
    )
    return "{\n" + ",\n".join(lines) + "\n}\n"
