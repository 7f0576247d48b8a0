"""Dashboard and alert rules use only metrics that /metrics has."""

import itertools
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from tests.app.ops.rare import rare_readings
from tests.kit.serving import Running

DEPLOY = Path(__file__).parents[3] / "deploy"
DASHBOARD = DEPLOY / "grafana" / "dashboard.json"
METRIC = re.compile(r"\b(?:(?:plinko|process)_\w+|up\b)")


@cache
def rules() -> list[dict[str, Any]]:
    groups = yaml.safe_load((DEPLOY / "alerts.yml").read_text())["groups"]
    return [rule for group in groups for rule in group["rules"]]


@cache
def panels() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(DASHBOARD.read_text())["panels"]
    return found


@pytest.fixture
def samples(server: Running) -> dict[str, set[str]]:
    """The labels of each sample in /metrics by its name, including those of rare metrics."""
    found: dict[str, set[str]] = {}
    for family in text_string_to_metric_families(server.get("/metrics").text):
        for sample in family.samples:
            found.setdefault(sample.name, set()).update(sample.labels)
    found["up"] = set()  # made by Prometheus for each server that it scrapes
    found.setdefault("plinko_errors_total", {"code"})  # exists after the first error
    for name, _, _, labels in rare_readings():
        found[name] = set(labels)
    return found


def asked(expression: str, samples: dict[str, set[str]]) -> set[str]:
    """The metrics in an expression; asserts that they exist, with the labels it groups by."""
    names = set(METRIC.findall(expression))
    assert names, expression
    assert names - samples.keys() == set(), expression
    labels = set.union({"instance", "job"}, *(samples[name] for name in names))
    for group in re.findall(r"\b(?:by|ignoring|on) \((.*?)\)", expression):
        assert set(group.split(", ")) <= labels, expression
    for label in re.findall(r"(\w+)=~?\"", expression):
        assert label in labels, expression
    return names


def test_every_metric_of_the_dashboard_is_there(samples: dict[str, set[str]]) -> None:
    for panel in panels():
        assert panel["targets"], panel["title"]
        for target in panel["targets"]:
            asked(target["expr"], samples)


def test_the_dashboard_s_panels_do_not_overlap_and_have_texts() -> None:
    places = set()
    for panel in panels():
        where = panel["gridPos"]
        assert 0 <= where["x"] <= 24 - where["w"]
        columns = range(where["x"], where["x"] + where["w"])
        rows = range(where["y"], where["y"] + where["h"])
        places |= set(itertools.product(columns, rows))
        assert panel["title"]
        assert panel["fieldConfig"]["defaults"]["unit"]
        ids = [target["refId"] for target in panel["targets"]]
        assert ids == sorted(set(ids))
    assert len(places) == sum(each["gridPos"]["w"] * each["gridPos"]["h"] for each in panels())
    assert len({panel["id"] for panel in panels()}) == len(panels())
    assert len({panel["title"] for panel in panels()}) == len(panels())


def test_every_metric_of_an_alert_is_there(samples: dict[str, set[str]]) -> None:
    for rule in rules():
        asked(rule["expr"], samples)
        assert rule["annotations"]["summary"]
        assert rule["labels"]["severity"] in ("critical", "warning")
    assert len(rules()) == len({rule["alert"] for rule in rules()}) >= 6
