"""How often a client may do something, and how much it may have. Pure; time is brought along."""

import functools
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import ceil
from typing import NamedTuple

from app.errors import BudgetError, QuotaError, RateLimitError


class Allowance(NamedTuple):
    """What a client may do and what is left of it, as the headers `RateLimit` tell it.

    `quota` at once, all of it again after `window` seconds; `left` now, all of it in `reset` s.
    (draft-ietf-httpapi-ratelimit-headers)
    """

    name: str
    quota: int
    window: int
    left: int
    reset: int

    @property
    def policy(self) -> str:
        """An item of `RateLimit-Policy`."""
        return f'"{self.name}";q={self.quota};w={self.window}'

    @property
    def rest(self) -> str:
        """An item of `RateLimit`."""
        return f'"{self.name}";r={self.left};t={self.reset}'


_ALWAYS = 3  # things that each key may have, however few are left


class TokenBucket:
    """Allows `rate` acts a second on average, and `burst` of them at once."""

    __slots__ = ("_at", "_tokens", "burst", "rate")

    def __init__(self, rate: float, burst: float, now: float) -> None:
        self.rate = rate
        self.burst = burst
        self._tokens = burst
        self._at = now

    def take(self, now: float) -> bool:
        """Spend one token at time `now` (seconds); False when none is left."""
        if self.left(now) < 1.0:
            return False
        self._tokens -= 1.0
        return True

    def left(self, now: float) -> float:
        """Tokens there are at time `now`; below 0 by what was charged beyond."""
        self._tokens = min(self.burst, self._tokens + max(0.0, now - self._at) * self.rate)
        self._at = now
        return self._tokens

    def allowance(self, name: str, now: float, unit: float = 1.0) -> Allowance:
        """What there is at time `now`, counted in parts of a token: 1,000 a token if `unit` is."""
        left = self.left(now)
        return Allowance(
            name=name,
            quota=int(self.burst * unit),
            window=ceil(self.burst / self.rate),
            left=max(0, int(left * unit)),
            reset=ceil((self.burst - left) / self.rate),
        )

    def charge(self, tokens: float) -> None:
        """Take so many tokens whether there are as many or not; give some back with a negative."""
        self._tokens = min(self.burst, self._tokens - tokens)

    def wait(self) -> float:
        """Seconds until the next token, counted from the last `take`."""
        return max(0.0, (1.0 - self._tokens) / self.rate)


class KeyedBuckets:
    """One bucket a key (a client's address); forgets the longest unseen beyond `size` keys."""

    def __init__(self, rate: float, burst: float, size: int = 10_000) -> None:
        self.rate = rate
        self.burst = burst
        self.size = size
        self._buckets: OrderedDict[str, TokenBucket] = OrderedDict()

    def take(self, key: str, now: float, what: str) -> None:
        """Spend one token of `key`; raises RateLimitError naming `what` and the rate."""
        spend(self.bucket(key, now), now, what)

    def allowance(self, key: str, now: float, name: str) -> Allowance:
        """What `key` may do, and what is left of it."""
        return self.bucket(key, now).allowance(name, now)

    def bucket(self, key: str, now: float) -> TokenBucket:
        """The bucket of `key`, a full one where there is none yet."""
        bucket = self._buckets.get(key)
        if bucket is None:
            bucket = self._buckets[key] = TokenBucket(self.rate, self.burst, now)
            if len(self._buckets) > self.size:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(key)
        return bucket


UNREAD_EVENTS = 256  # frames that may wait for one client
UNREAD_BYTES = 1 << 20  # of them
READING_GRACE = 5.0  # s for which a client may leave unread what it is sent
LINGER = 5.0  # s that a client which was closed for slowness has to read why

COMPUTE_RATE = 0.5
"""s of a core that one address may have computed in each second, beyond what it may at once."""

COMPUTE_BURST = 30.0
"""s of a core that one address may have computed at once: the dearest requests, one after another,
or a class of thirty behind one address that opens a page of drops together."""


class Budgets:
    """How many seconds of a core each key (a client's address) may have computed, as they come.

    What a request takes is only known afterwards: its price is charged before, the difference
    then. Who has overdrawn by one request waits until that is paid.
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._buckets = KeyedBuckets(rate, burst)

    def charge(self, key: str, now: float, seconds: float, what: str) -> None:
        """Charge a request's price; raises BudgetError that names it when nothing is left."""
        bucket = self._buckets.bucket(key, now)
        left = bucket.left(now)
        if left <= 0.0:
            raise BudgetError(
                f"{what} takes about {seconds:.2g} s to compute, and this address has had "
                f"{bucket.burst:g} s and {bucket.rate:g} more each second",
                retry_after=(min(seconds, bucket.burst) - left) / bucket.rate,
            )
        bucket.charge(seconds)

    def allowance(self, key: str, now: float, name: str) -> Allowance:
        """What `key` may have computed, in ms of a core, and what is left of it."""
        return self._buckets.bucket(key, now).allowance(name, now, 1000.0)

    def wait(self, key: str, now: float) -> float:
        """How long until the key has something left, in s."""
        bucket = self._buckets.bucket(key, now)
        return max(0.0, -bucket.left(now)) / bucket.rate

    def settle(self, key: str, now: float, seconds: float) -> None:
        """Charge what a request took beyond its price, in s; what it took less is given back."""
        bucket = self._buckets.bucket(key, now)
        bucket.left(now)  # a full bucket gains nothing while a request takes long
        bucket.charge(seconds)


class Quota:
    """How many things of a kind each key may have at a time; `is_open` says which still are.

    What was there before the server started is nobody's: it counts for no key.
    """

    def __init__(self, most: int, what: str, is_open: Callable[[str], bool]) -> None:
        self.most = most
        self.what = what
        self._is_open = is_open
        self._held: dict[str, list[str]] = {}
        self._coming: Counter[str] = Counter()

    @contextmanager
    def place(
        self, key: str, left: int | None = None, held: int | None = None
    ) -> Iterator[Callable[[str], None]]:
        """A place for one more, to be filled in the block by calling what it gives with its name.

        Where only `left` more are to be had, by all, one key may have a tenth of that, so that a
        few keys do not take what is there from all others. `held` says how many it has, where
        somebody else counts them. Raises QuotaError when `key` has as many
        as it may, those in the making counted.
        """
        share = self.most if left is None else max(_ALWAYS, left // 10)
        self._check(key, min(self.most, share), held)
        self._coming[key] += 1
        try:
            yield functools.partial(self._add, key)
        finally:
            self._coming[key] -= 1
            if not self._coming[key]:
                del self._coming[key]

    def _check(self, key: str, most: int, counted: int | None) -> None:
        held = [thing for thing in self._held.get(key, ()) if self._is_open(thing)]
        if held:
            self._held[key] = held
        else:
            self._held.pop(key, None)
        count = (len(held) if counted is None else counted) + self._coming[key]
        if count >= most:
            raise QuotaError(f"{count} {self.what} are open already, of {most} at most now")

    def _add(self, key: str, thing: str) -> None:
        if key not in self._held:
            for other in list(self._held):  # those who will not come back are forgotten
                self._held[other] = [old for old in self._held[other] if self._is_open(old)]
                if not self._held[other]:
                    del self._held[other]
        self._held.setdefault(key, []).append(thing)


def spend(bucket: TokenBucket, now: float, what: str) -> None:
    """Spend one token; raises RateLimitError naming `what`, the rate and when to come back."""
    if not bucket.take(now):
        raise RateLimitError(
            f"more than {bucket.rate:g} {what} a second", retry_after=bucket.wait()
        )
