"""After any failure, events that clients received, ledger and physics agree."""

from dataclasses import dataclass, field
from typing import Any

from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import store
from plinko.app.rooms.stakes import payout_of
from plinko.engine import Board, drop

_START = ("ball", "seed", "x", "tick")


@dataclass
class Told:
    """All events of one room that clients received, over every connection and every restart."""

    room: str
    accepted: dict[int, dict[str, Any]] = field(default_factory=dict)
    landed: dict[int, dict[str, Any]] = field(default_factory=dict)
    refused: set[str] = field(default_factory=set)  # seeds; each is dropped once
    receipts: dict[str, list[dict[str, Any]]] = field(default_factory=dict)  # by session

    def hear(self, event: dict[str, Any]) -> None:
        """Record an `accepted` or a `landed` event."""
        event = {key: value for key, value in event.items() if key != "type"}
        if "explicit_x" in event:
            assert event["ball"] not in self.accepted, "a ball's number was given twice"
            stake = event.get("stake", 0)
            self.accepted[event["ball"]] = {key: event[key] for key in _START} | {
                "stake": stake,
                "practice": event.get("practice", False),
            }
            if "receipt" in event:
                signed = event["receipt"]
                self.receipts.setdefault(signed["receipt"]["session"], []).append(signed)
        else:
            before = self.landed.setdefault(event["ball"], event)
            assert before == event, "a ball landed twice, and differently"


def hold(url: str, told: Told, board: Board, *, killed: bool = False, shared: bool = False) -> int:
    """Compare the ledger with the events that players received and with the physics.

    killed: the server was killed, perhaps amid a commit; the ledger may then have a drop whose
    player received no `accepted`, or a refusal. shared: servers use the ledger meanwhile.
    Returns the number of drops in the ledger.
    """
    database = Database(url, shared=shared)
    database.open(check=False, enter=False)
    try:
        with database.transaction() as connection:
            row = store.open_room(connection, told.room)
            kept = [] if row is None else store.drops(connection, row.number, 0)
    finally:
        database.close()
    for ball, event in told.accepted.items():
        found = kept[ball][0]
        stored = (found.ball, str(found.seed), found.tick, found.stake, found.practice)
        said = (ball, *(event[name] for name in ("seed", "tick", "stake", "practice")))
        assert stored == said
    for each, result in kept:
        if not killed:
            assert each.ball in told.accepted, f"{each} was never told"
            assert str(each.seed) not in told.refused, f"{each} was refused"
        alone = drop(board, each.seed, x=each.x)
        assert result is not None, f"ball {each.ball} never landed"
        assert (result.digest, result.bin) == (alone.digest, alone.bin)
        assert result.payout == payout_of(each.stake, alone.score)
        heard = told.landed.get(each.ball)
        if heard is not None:
            same = {"seed": str(each.seed), "payout": result.payout} | {
                name: getattr(result, name) for name in ("digest", "tick", "bin", "score")
            }
            assert {name: heard.get(name, 0) for name in same} == same
    assert told.landed.keys() <= {each.ball for each, _ in kept}, "a ball landed that is not there"
    return len(kept)
