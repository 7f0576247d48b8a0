"""Token buckets, budgets and quotas."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.errors import BudgetError, QuotaError, RateLimitError, retry_after
from plinko.app.web.limits import Budgets, KeyedBuckets, Quota, TokenBucket, spend


@given(st.lists(st.floats(0.0, 2.0), max_size=200), st.floats(0.1, 100.0), st.integers(1, 50))
def test_no_window_allows_more_than_burst_and_rate(
    gaps: list[float], rate: float, burst: int
) -> None:
    bucket = TokenBucket(rate, burst, 0.0)
    now, taken = 0.0, 0
    for gap in gaps:
        now += gap
        taken += bucket.take(now)
    assert taken <= burst + rate * now + 1e-6


def test_a_bucket_refills_and_says_when() -> None:
    bucket = TokenBucket(2.0, 3, 100.0)
    assert [bucket.take(100.0) for _ in range(4)] == [True, True, True, False]
    assert bucket.wait() == pytest.approx(0.5)
    assert bucket.take(100.5)
    assert not bucket.take(100.5)
    # A clock that steps back gives nothing away.
    bucket = TokenBucket(1.0, 1, 100.0)
    assert bucket.take(100.0)
    assert not bucket.take(50.0)
    # Spending too fast names the rate, and when to come back.
    bucket = TokenBucket(4.0, 1, 0.0)
    spend(bucket, 0.0, "drops")
    with pytest.raises(RateLimitError, match="more than 4 drops a second") as caught:
        spend(bucket, 0.0, "drops")
    assert caught.value.retry_after == pytest.approx(0.25)


def test_keys_do_not_share_and_the_longest_unseen_is_forgotten() -> None:
    buckets = KeyedBuckets(1.0, 1, size=2)
    buckets.take("a", 0.0, "drops")
    buckets.take("b", 0.0, "drops")
    with pytest.raises(RateLimitError):
        buckets.take("a", 0.0, "drops")
    buckets.take("c", 0.0, "drops")  # the bucket of b is removed
    with pytest.raises(RateLimitError):
        buckets.take("a", 0.0, "drops")
    buckets.take("b", 0.0, "drops")


def test_a_key_has_a_bounded_number_of_places() -> None:
    quota = Quota("rooms")
    with quota.place("me", has=1, left=40), quota.place("me", has=1, left=40):
        with quota.place("me", has=1, left=40):
            said = "4 rooms are open already; at most 4 may be open now"
            with pytest.raises(QuotaError, match=said), quota.place("me", has=1, left=40):
                raise AssertionError("there was a place")
        with quota.place("you", has=3, left=40):
            pass
    with quota.place("me", has=3, left=40), contextlib.suppress(ZeroDivisionError):
        raise ZeroDivisionError("what fails takes no place")
    with pytest.raises(QuotaError), quota.place("me", has=4, left=40):
        raise AssertionError("there was a place")
    assert not quota._coming, "what is not being made needs no memory"
    assert retry_after(QuotaError("x")) == 1


def test_the_less_is_left_the_less_each_client_may_take() -> None:
    held: dict[str, int] = {}
    left = 1000
    quota = Quota("rooms")
    for client in map(str, range(40)):
        with contextlib.suppress(QuotaError):
            while True:
                with quota.place(client, has=held.get(client, 0), left=left):
                    held[client] = held.get(client, 0) + 1
                    left -= 1
    assert max(held.values()) == 91, "the first one has a tenth of what is free then"
    assert min(held.values()) >= 3, "even the last of them found room"
    assert left > 0


def test_a_budget_is_spent_by_prices_and_comes_back_with_time() -> None:
    budgets = Budgets(rate=0.5, burst=10.0)
    budgets.charge("a", 0.0, 8.0, "pixels")
    budgets.charge("a", 0.0, 8.0, "pixels")  # a budget that is not empty may be overdrawn once
    with pytest.raises(BudgetError, match=r"takes about 8 s .* 10 s, .* 0\.5 s each") as refused:
        budgets.charge("a", 0.0, 8.0, "pixels")
    assert refused.value.retry_after == pytest.approx(28.0)
    budgets.charge("b", 0.0, 8.0, "pixels")
    budgets.charge("a", 12.5, 0.1, "pixels")


def test_what_a_request_took_counts_and_not_its_price() -> None:
    budgets = Budgets(rate=0.5, burst=10.0)
    for _ in range(100):
        budgets.charge("a", 0.0, 5.0, "events")
        budgets.settle("a", 0.0, -4.99)
    budgets.charge("a", 0.0, 0.1, "events")
    budgets.settle("a", 0.0, 20.0)
    with pytest.raises(BudgetError):
        budgets.charge("a", 0.0, 0.1, "events")
