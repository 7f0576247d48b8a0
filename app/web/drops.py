"""Parses a requested drop, from REST or a WebSocket, into the `DropCommand` used inside."""

from collections.abc import Callable

from plinko.app.errors import InvalidValueError
from plinko.app.protocol.client_messages import DropMessage, parse_place
from plinko.app.protocol.visitors import parse_tag
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.stakes import parse_stake, parse_who
from plinko.app.web.schemas.rooms import RoomDropRequest
from plinko.engine.seeding import parse_seed


def drop_command(form: DropMessage | RoomDropRequest, draw: Callable[[], int]) -> DropCommand:
    """Parse a request for a drop; `draw` returns the seed if the request has none.

    Raises SeedError for a bad seed, and InvalidValueError for any other bad value or for a stake
    without a session.
    """
    seed = None if form.seed is None else parse_seed(form.seed)
    x, aim = parse_place(form.x, "x"), parse_place(form.aim, "aim")
    stake, who = parse_stake(form.stake), parse_who(form.who)
    if stake and form.session is None:
        raise InvalidValueError(
            f"stake {stake}: only a drop of a session can have a stake, because nobody can choose "
            "its start; give `session`, or leave out `stake` for a practice drop",
            field="stake",
        )
    return DropCommand(
        seed=draw() if seed is None else seed,
        x=x,
        stake=stake,
        who=who,
        aim=aim,
        practice=seed is not None or x is not None,
        tag=parse_tag(form.name, form.colour),
    )
