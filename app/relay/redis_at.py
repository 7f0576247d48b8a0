"""Imports the bus over Redis only when one is used, because its client is an optional package."""

from importlib import import_module
from typing import Any

from plinko.app.relay.bus import Carried
from plinko.engine.errors import MissingPartError


def redis_at(url: str) -> Carried:
    """The bus at `url`; raises MissingPartError if the client is not installed, SettingError."""
    try:
        module: Any = import_module("plinko.app.relay.redis_bus")
    except ModuleNotFoundError as error:
        if error.name != "redis":
            raise
        raise MissingPartError(
            "relays need the Redis client: pip install 'plinko-sim[redis]'"
        ) from None
    bus: Carried = module.RedisBus(url)
    return bus
