"""A drop as it is asked for, over REST or a socket: read once, into what everybody inside uses."""

from collections.abc import Callable

from app.errors import InvalidValueError
from app.protocol.client_messages import DropMessage, parse_aim, parse_x
from app.protocol.visitors import parse_tag
from app.rooms.pending import DropCommand
from app.rooms.stakes import parse_stake, parse_who
from app.web.schemas.rooms import RoomDropRequest
from engine.seeding import parse_seed


def drop_command(form: DropMessage | RoomDropRequest, draw: Callable[[], int]) -> DropCommand:
    """What is asked for; `draw` gives the seed where none is chosen.

    Raises SeedError, and InvalidValueError for the other values, among them a stake without a
    session.
    """
    seed = None if form.seed is None else parse_seed(form.seed)
    x, aim = parse_x(form.x), parse_aim(form.aim)
    stake, who = parse_stake(form.stake), parse_who(form.who)
    if stake and form.session is None:
        raise InvalidValueError(
            f"stake {stake}: a stake needs a session, in which nobody can choose a start; with a "
            "seed or x of one's own, and without a session, a drop is practice",
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
