"""Loads a table from its facts: its sums, and the flights of balls that have not landed. Pure."""

from app.protocol import messages
from app.rooms.independent import IndependentRoom
from app.rooms.records import TableState
from engine.drops.flight import fly


def load(room: IndependentRoom, state: TableState, tick: int) -> list[messages.Landed]:
    """Bring a new room to this tick; returns the landings that have no result in the ledger."""
    flying = [(fact, fly(room.board, room.start_of(fact))) for fact in state.flying]
    return room.load(state, flying, tick)


def landings(room: IndependentRoom, state: TableState) -> list[messages.Landed]:
    """How the balls without a result land, for a run that ends."""
    flying = ((fact, fly(room.board, room.start_of(fact))) for fact in state.flying)
    return [room.landing(fact, flight) for fact, flight in flying]
