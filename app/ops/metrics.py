"""Metrics of the server for Prometheus.

A tick only updates plain numbers and two histograms. All other values are read from the parts of
the server when Prometheus requests them.
"""

from collections.abc import Callable, Iterable

from prometheus_client import (
    CollectorRegistry,
    Counter,
    GCCollector,
    Histogram,
    PlatformCollector,
    ProcessCollector,
)
from prometheus_client.exposition import choose_encoder
from prometheus_client.metrics_core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

_TICK_BUCKETS = (1e-4, 2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2, 3.2e-2, 6.4e-2, 0.25, 1.0)
_COMMIT_BUCKETS = (2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2, 3.2e-2, 6.4e-2, 0.25, 1.0, 4.0)

Reading = tuple[str, str, float, dict[str, str]]
"""Name, help text, value and labels. A name ending in _total is a counter, any other a gauge."""


class Metrics:
    """One server's metrics; the ticker calls them after each tick."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        for collector in (ProcessCollector, PlatformCollector, GCCollector):
            collector(registry=self.registry)
        self.tick_duration = Histogram(
            "plinko_tick_duration_seconds",
            "Duration of a tick: physics, encoding and passing the frames to the system.",
            buckets=_TICK_BUCKETS,
            registry=self.registry,
        )
        self.tick_lateness = Histogram(
            "plinko_tick_lateness_seconds",
            "Delay of the start of a tick after its due time.",
            buckets=_TICK_BUCKETS,
            registry=self.registry,
        )
        self.ledger_commit = Histogram(
            "plinko_ledger_commit_seconds",
            "Time until a group of drops was durable.",
            buckets=_COMMIT_BUCKETS,
            registry=self.registry,
        )
        self.errors = Counter(
            "plinko_errors",
            "Errors sent to clients over HTTP and WebSocket, by code.",
            ["code"],
            registry=self.registry,
        )

    def read_from(self, readings: Callable[[], Iterable[Reading]]) -> None:
        """Call `readings` for more values whenever the metrics are requested."""
        self.registry.register(_Reader(readings))

    def exposition(self, accept: str) -> tuple[bytes, str]:
        """All metrics in the text format preferred by an Accept header, and its media type."""
        encode, media_type = choose_encoder(accept)
        return encode(self.registry), media_type

    def ticked(self, late: float, duration: float) -> None:
        """Record a tick that began `late` s after its due time and took `duration` s."""
        self.tick_lateness.observe(late)
        self.tick_duration.observe(duration)


class _Reader(Collector):
    """Converts readings into metrics."""

    def __init__(self, readings: Callable[[], Iterable[Reading]]) -> None:
        self._readings = readings

    def collect(self) -> Iterable[Metric]:
        """Collect one metric for all readings with the same name."""
        families: dict[str, CounterMetricFamily | GaugeMetricFamily] = {}
        for name, text, value, labels in self._readings():
            if name not in families:
                kind = CounterMetricFamily if name.endswith("_total") else GaugeMetricFamily
                families[name] = kind(name.removesuffix("_total"), text, labels=list(labels))
            families[name].add_metric(list(labels.values()), value)
        return families.values()

    def describe(self) -> Iterable[Metric]:
        """Describe nothing at registration: the server's parts may not exist yet."""
        return ()
