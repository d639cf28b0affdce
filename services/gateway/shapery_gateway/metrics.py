"""Metrics in the text format of Prometheus, in a registry of the app's own."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

logger = logging.getLogger(__name__)

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


class RequestMetrics:
    """Counts and latencies of requests, by route and never by path."""

    def __init__(self, registry: CollectorRegistry) -> None:
        self.registry = registry
        self.requests = Counter(
            "shapery_http_requests", "Requests answered.", ["method", "route", "status"], registry=registry
        )
        self.latency = Histogram(
            "shapery_http_request_seconds",
            "Seconds until the answer began.",
            ["method", "route"],
            buckets=(0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300),
            registry=registry,
        )
        self.in_progress = Gauge("shapery_http_requests_in_progress", "Requests being served.", registry=registry)
        self.streams = Gauge("shapery_event_streams", "Open event streams.", registry=registry)
        self.upload_bytes = Counter("shapery_upload_bytes", "Bytes of uploads taken in.", registry=registry)
        self.enqueue_failures = Counter(
            "shapery_enqueue_failures", "Jobs left to the reaper because the broker did not answer.", registry=registry
        )
        self.searches = Counter(
            "shapery_searches",
            "Searches by what answered them: a resident process, a job in time, or a job later.",
            ["answered"],
            registry=registry,
        )

    def observe(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count one request. A method nobody knows is counted as ``other``, so that none can add series at will."""
        known = method if method in {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"} else "other"
        self.requests.labels(known, route, str(status)).inc()
        self.latency.labels(known, route).observe(seconds)

    def render(self) -> bytes:
        """Return all metrics as text."""
        return generate_latest(self.registry)


class PlatformCollector(Collector):
    """Asks the platform at each scrape; a part that does not answer leaves its metrics out and says so in one."""

    def __init__(self, sources: Mapping[str, tuple[str, str, Callable[[], Mapping[str, float]]]]) -> None:
        """Take, for each metric name, its help, its label and the function that tells values by label."""
        self.sources = sources

    def collect(self) -> Iterable[Metric]:
        """Yield one gauge per source."""
        up = GaugeMetricFamily("shapery_scrape_ok", "Whether a source of metrics answered.", labels=["source"])
        for name, (text, label, read) in self.sources.items():
            try:
                values = read()
            except Exception as error:
                logger.warning("metrics source %s does not answer: %s", name, type(error).__name__)
                up.add_metric([name], 0)
                continue
            up.add_metric([name], 1)
            family = GaugeMetricFamily(name, text, labels=[label])
            for key, value in values.items():
                family.add_metric([key], value)
            yield family
        yield up
