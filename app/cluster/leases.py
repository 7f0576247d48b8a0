"""Leases in Redis: each server says every now and then that it is alive; who is silent is gone."""

import secrets
from typing import Final

import msgspec
from redis.asyncio import Redis
from redis.asyncio.retry import Retry
from redis.backoff import NoBackoff
from redis.exceptions import RedisError

from app.cluster.membership import LEASE, Look, Member
from app.errors import SettingError

_PREFIX: Final = "plinko:cluster:"
_MEMBERS: Final = f"{_PREFIX}members"
_STORE: Final = f"{_PREFIX}store"

_SECONDS: Final = 0.5
"""s that Redis may take to answer: beyond that it counts as away."""

FAILURES: Final = (RedisError, OSError)
"""What any of this raises while Redis is away."""


class Leases:
    """A server's end of the lease store."""

    def __init__(self, url: str) -> None:
        self._beats = 0
        try:
            self._redis = Redis.from_url(
                url,
                socket_timeout=_SECONDS,
                socket_connect_timeout=_SECONDS,
                retry=Retry(NoBackoff(), 0),
                decode_responses=True,
            )
        except ValueError as error:
            raise SettingError(
                f"cluster={url!r} is no address of a Redis: {error}", field="cluster"
            ) from None

    async def beat(self, me: Member) -> Look:
        """Say that `me` is alive, and see who else is; raises FAILURES."""
        self._beats += 1
        me = msgspec.structs.replace(me, beats=self._beats)
        async with self._redis.pipeline(transaction=False) as pipeline:
            pipeline.set(_key(me.holder), msgspec.json.encode(me), px=int(LEASE * 1000))
            pipeline.sadd(_MEMBERS, me.holder)
            pipeline.set(_STORE, secrets.token_hex(8), nx=True)
            pipeline.get(_STORE)
            pipeline.smembers(_MEMBERS)
            *_, store, names = await pipeline.execute()
        holders = sorted(names)
        found = await self._redis.mget([_key(each) for each in holders])
        silent = [holder for holder, value in zip(holders, found, strict=True) if value is None]
        if silent:
            await self._redis.srem(_MEMBERS, *silent)
        members = tuple(msgspec.json.decode(value, type=Member) for value in found if value)
        return Look(str(store), members)

    async def leave(self, me: Member) -> None:
        """Say that `me` is gone; raises FAILURES."""
        await self._redis.delete(_key(me.holder))

    async def close(self) -> None:
        """Leave Redis."""
        await self._redis.aclose()


def _key(holder: str) -> str:
    return f"{_PREFIX}member:{holder}"
