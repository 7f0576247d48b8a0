"""The log names an unconfigured proxy, behind which all players would share one limit."""

import logging

import httpx
import pytest

from tests.kit.serving import serving
from tests.kit.waiting import LIMIT

WHO = {"x-forwarded-for": "203.0.113.9"}


def warnings(caplog: pytest.LogCaptureFixture) -> list[str]:
    told = [each.getMessage() for each in caplog.records if each.levelno == logging.WARNING]
    return [each for each in told if "X-Forwarded-For" in each]


def asked_twice(**settings: object) -> None:
    with serving(**settings) as server:
        for _ in range(2):
            assert httpx.get(f"{server.url}/healthz", headers=WHO, timeout=LIMIT).is_success
        assert httpx.get(f"{server.url}/healthz", timeout=LIMIT).is_success


def test_a_proxy_that_is_not_trusted_is_named_once(caplog: pytest.LogCaptureFixture) -> None:
    asked_twice()
    (told,) = warnings(caplog)
    assert "from 127.0.0.1 is ignored" in told
    assert "--trusted-proxies" in told


def test_a_trusted_proxy_is_not(caplog: pytest.LogCaptureFixture) -> None:
    asked_twice(trusted_proxies=("127.0.0.1",))
    assert warnings(caplog) == []


FORMS = {
    "an IPv4 address": "203.0.113.9",
    "with a port": "203.0.113.9:{}",
    "IPv6 with a port": "[2001:db8::9]:{}",
    "IPv6 of one subscriber": "[2001:db8::{:x}]",
    "an IPv4 address as IPv6, with a port": "[::ffff:203.0.113.9]:{}",
    "no address": "unknown{}",
    "an invalid port": "203.0.113.9:x{}",
    "an address of the proxy itself": "203.0.113.9, 127.0.0.1:{}",
    "an open bracket": "[2001:db8::9:{}",
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_whatever_else_a_proxy_says_of_a_client_its_limits_are_the_same(form: str) -> None:
    with serving(trusted_proxies=("127.0.0.1",), drop_rate=1.0) as server, server.client() as http:
        statuses = {
            http.post(
                "/api/v1/rooms/main/drops", headers={"x-forwarded-for": form.format(4000 + port)}
            ).status_code
            for port in range(30)
        }
    assert 429 in statuses
