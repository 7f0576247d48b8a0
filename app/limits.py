"""Token buckets: how often a client may do something. Pure; the caller brings the time."""

from collections import OrderedDict

from app.errors import RateLimitError


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
        self._tokens = min(self.burst, self._tokens + max(0.0, now - self._at) * self.rate)
        self._at = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True

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
        bucket = self._buckets.get(key)
        if bucket is None:
            bucket = self._buckets[key] = TokenBucket(self.rate, self.burst, now)
            if len(self._buckets) > self.size:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(key)
        spend(bucket, now, what)


def spend(bucket: TokenBucket, now: float, what: str) -> None:
    """Spend one token; raises RateLimitError naming `what`, the rate and when to come back."""
    if not bucket.take(now):
        raise RateLimitError(
            f"more than {bucket.rate:g} {what} a second", retry_after=bucket.wait()
        )
