"""Each alert of deploy/alerts.yml fires when it should and not otherwise, as Prometheus sees it."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any, Final

import pytest
import yaml

from tests.kit.waiting import LIMIT

RULES: Final = Path(__file__).parents[2] / "deploy" / "alerts.yml"
PROMTOOL: Final = shutil.which("promtool")

# What fires each alert, in Prometheus' notation of a series: 0+9x40 is 0 9 18 … at each 15 s.
FIRED_BY: Final[dict[str, dict[str, str]]] = {
    "PlinkoDown": {'up{job="plinko"}': "0x40"},
    "PlinkoServerOrRelayDown": {'up{job="relays"}': "1x9 0x30"},
    "PlinkoTicksStopped": {"plinko_rooms_awake": "1x40", "plinko_ticks_total": "9x40"},
    "PlinkoReturnOutOfTolerance": {
        "plinko_return": "0.9x99", "plinko_return_expected": "0.99x99",
        "plinko_return_tolerance": "0.01x99",
    },
    "PlinkoDropsRefused": {
        "plinko_drops_total": "0+1x60", 'plinko_drops_refused_total{result="refused"}': "0+1x60",
        'plinko_drops_refused_total{result="undecided"}': "0+1x60", "plinko_ledger_up": "1x60",
    },
    "PlinkoRedisAway": {"plinko_redis_up": "1x9 0x30"},
    "PlinkoWebhookLate": {'plinko_webhook_oldest_seconds{target="a.example"}': "0+15x40"},
    "PlinkoLedgerDamaged": {"plinko_ledger_sound": "0x40", "plinko_rooms_set_aside": "0x40"},
    "PlinkoLedgerLogGrows": {"plinko_ledger_log_bytes": "2e9x60"},
    "PlinkoLedgerDown": {"plinko_ledger_up": "0x40"},
    "PlinkoRoomSilent": {"plinko_room_late_ticks_total": "0+1x40"},
    "PlinkoTicksLate": {
        'plinko_tick_lateness_seconds_bucket{le="0.004"}': "0+95x60",
        "plinko_tick_lateness_seconds_count": "0+100x60",
    },
    "PlinkoServerErrors": {'plinko_errors_total{code="server-error"}': "0+1x40"},
    "PlinkoMembersUnseen": {"plinko_cluster_leases_up": "0x40"},
    "PlinkoServerGone": {"plinko_cluster_members": "3x9 2x40"},
    "PlinkoRoomsTakenOver": {"plinko_cluster_taken_over_total": "0x9 1x40"},
}  # fmt: skip

FINE: Final[dict[str, str]] = {
    'up{job="plinko"}': "1x99", "plinko_rooms_awake": "1x99", "plinko_ticks_total": "0+900x99",
    "plinko_return": "0.985x99", "plinko_return_expected": "0.99x99",
    "plinko_return_tolerance": "0.01x99",
    "plinko_drops_total": "0+9x99", 'plinko_drops_refused_total{result="refused"}': "0+8x99",
    "plinko_ledger_up": "1x99", "plinko_ledger_sound": "1x99", "plinko_rooms_set_aside": "0x99",
    "plinko_redis_up": "1x20 0 1x78",
    'plinko_webhook_oldest_seconds{target="a.example"}': "50x99",
    "plinko_ledger_log_bytes": "2e7x99", "plinko_room_late_ticks_total": "0x99",
    'plinko_tick_lateness_seconds_bucket{le="0.004"}': "0+995x99",
    "plinko_tick_lateness_seconds_count": "0+1000x99", "plinko_ticks_skipped_total": "3x99",
    'plinko_errors_total{code="rate-limited"}': "0+9x99", "plinko_cluster_leases_up": "1x99",
    "plinko_cluster_members": "3x99", "plinko_cluster_taken_over_total": "0x99",
}  # fmt: skip


def case(series: dict[str, str], firing: str, alert: str, minutes: str = "10m") -> dict[str, Any]:
    """A test of promtool: whether these series, of one server, fire this alert."""
    named = {f"{name}{{}}" if "{" not in name else name: it for name, it in series.items()}
    return {
        "name": f"{alert} {'fires' if firing else 'is silent'}",
        "interval": "15s",
        "input_series": [{"series": name, "values": it} for name, it in named.items()],
        "promql_expr_test": [
            {
                "expr": f'count(ALERTS{{alertname="{alert}", alertstate="firing"}})',
                "eval_time": minutes,
                "exp_samples": [{"labels": "{}", "value": 1}] if firing else [],
            }
        ],
    }


@pytest.mark.skipif(PROMTOOL is None, reason="no promtool: apt-get install prometheus")
def test_each_alert_fires_when_it_should_and_not_otherwise(tmp_path: Path) -> None:
    names = [rule["alert"] for rule in yaml.safe_load(RULES.read_text())["groups"][0]["rules"]]
    assert sorted(names) == sorted(FIRED_BY)
    tests = [case(series, "firing", name, "20m" if "return" in str(series) else "10m")
             for name, series in FIRED_BY.items()]  # fmt: skip
    tests += [case(FINE, "", name) for name in names]
    file = tmp_path / "tests.yml"
    file.write_text(json.dumps({"rule_files": [str(RULES)], "tests": tests}))
    done = subprocess.run(
        [str(PROMTOOL), "test", "rules", str(file)],
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
