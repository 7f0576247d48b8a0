"""How often a client may do something, and how much it may have. Pure: time is an argument."""

from collections import Counter, OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil
from typing import NamedTuple

from plinko.app.errors import BudgetError, QuotaError, RateLimitError


class Allowance(NamedTuple):
    """One limit of a client, as the `RateLimit` headers state it.

    The client may use `quota` at once, and all of it again after `window` seconds. It has `left`
    now, and will have all of it in `reset` seconds. (draft-ietf-httpapi-ratelimit-headers)
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


_ALWAYS = 3  # things that each key may have even when few are left


class TokenBucket:
    """Allows `rate` actions a second on average, and `burst` of them at once."""

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
        """The tokens at time `now`; negative if more was charged than there was."""
        self._tokens = min(self.burst, self._tokens + max(0.0, now - self._at) * self.rate)
        self._at = now
        return self._tokens

    def allowance(self, name: str, now: float, unit: float = 1.0) -> Allowance:
        """The limit at time `now`, with `unit` parts to a token: 1,000 turns seconds into ms."""
        left = self.left(now)
        return Allowance(
            name=name,
            quota=int(self.burst * unit),
            window=ceil(self.burst / self.rate),
            left=max(0, int(left * unit)),
            reset=ceil((self.burst - left) / self.rate),
        )

    def charge(self, tokens: float) -> None:
        """Take `tokens` even if fewer are left; a negative number gives tokens back."""
        self._tokens = min(self.burst, self._tokens - tokens)

    def wait(self) -> float:
        """Seconds until the next token, counted from the last `take`."""
        return max(0.0, (1.0 - self._tokens) / self.rate)


class KeyedBuckets:
    """One bucket for each key (a client's address).

    It keeps at most `size` buckets and forgets the least recently used first.
    """

    def __init__(self, rate: float, burst: float, size: int = 10_000) -> None:
        self.rate = rate
        self.burst = burst
        self.size = size
        self._buckets: OrderedDict[str, TokenBucket] = OrderedDict()

    def take(self, key: str, now: float, what: str) -> None:
        """Spend one token of `key`; raises RateLimitError naming `what` and the rate."""
        spend(self.bucket(key, now), now, what)

    def allowance(self, key: str, now: float, name: str) -> Allowance:
        return self.bucket(key, now).allowance(name, now)

    def bucket(self, key: str, now: float) -> TokenBucket:
        """The bucket of `key`; a new key gets a full one."""
        bucket = self._buckets.get(key)
        if bucket is None:
            bucket = self._buckets[key] = TokenBucket(self.rate, self.burst, now)
            if len(self._buckets) > self.size:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(key)
        return bucket


UNREAD_EVENTS = 256  # frames that may wait for one client
UNREAD_BYTES = 1 << 20  # bytes that may wait for one client
READING_GRACE = 5.0  # s for which a client may leave frames unread
LINGER = 5.0  # s in which a client closed for slowness can read the reason

COMPUTE_RATE = 0.5
"""Seconds of a core that one address gains each second, up to COMPUTE_BURST."""

COMPUTE_BURST = 30.0
"""Seconds of a core that one address may use at once. That is enough for the most expensive
requests one after another, or for a class of thirty behind one address that opens a page of drops
together."""


class Budgets:
    """The seconds of a core that each key (a client's address) may use.

    A request's cost is known only afterwards. Its estimated price is charged before, and the
    difference after. A request may overdraw the budget; the key's next one must wait until the
    budget is above zero again.
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._buckets = KeyedBuckets(rate, burst)

    def charge(self, key: str, now: float, seconds: float, what: str) -> None:
        """Charge a request's price, in s; raises BudgetError if nothing is left."""
        bucket = self._buckets.bucket(key, now)
        left = bucket.left(now)
        if left <= 0.0:
            raise BudgetError(
                f"{what} takes about {seconds:.2g} s to compute, but this address has used up its "
                f"budget of {bucket.burst:g} s, which refills by {bucket.rate:g} s each second; "
                "try again later",
                retry_after=(min(seconds, bucket.burst) - left) / bucket.rate,
            )
        bucket.charge(seconds)

    def allowance(self, key: str, now: float, name: str) -> Allowance:
        """The budget of `key`, in ms of a core."""
        return self._buckets.bucket(key, now).allowance(name, now, 1000.0)

    def wait(self, key: str, now: float) -> float:
        """Seconds until the key's budget is above zero."""
        bucket = self._buckets.bucket(key, now)
        return max(0.0, -bucket.left(now)) / bucket.rate

    def settle(self, key: str, now: float, seconds: float) -> None:
        """Charge the `seconds` that a request took beyond its price; negative ones go back."""
        bucket = self._buckets.bucket(key, now)
        bucket.left(now)  # refill first: a full bucket must not gain from the request's duration
        bucket.charge(seconds)


class Quota:
    """How many things of one kind each key may have open at a time."""

    def __init__(self, what: str) -> None:
        self.what = what
        self._coming: Counter[str] = Counter()

    @contextmanager
    def place(self, key: str, *, has: int, left: int) -> Iterator[None]:
        """Reserve a place while the block makes one more thing of `key`, which has `has` of them.

        `left` is how many more all keys together may open. One key may have only a tenth of them
        (but always three), so that a few keys cannot use up the rest. Raises QuotaError if `key`
        has its share already; things that are still being made count.
        """
        most, count = max(_ALWAYS, left // 10), has + self._coming[key]
        if count >= most:
            raise QuotaError(
                f"{count} {self.what} are open already; at most {most} may be open now"
            )
        self._coming[key] += 1
        try:
            yield
        finally:
            self._coming[key] -= 1
            if not self._coming[key]:
                del self._coming[key]


def spend(bucket: TokenBucket, now: float, what: str) -> None:
    """Spend one token; raises RateLimitError naming `what`, the rate and when to try again."""
    if not bucket.take(now):
        wait = bucket.wait()
        raise RateLimitError(
            f"more than {bucket.rate:g} {what} a second; try again in {wait:.1f} s",
            retry_after=wait,
        )
