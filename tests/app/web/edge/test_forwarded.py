"""The log names an unconfigured proxy, behind which all players would share one limit."""

import logging

import pytest

from tests.kit.serving import serving

WHO = {"x-forwarded-for": "203.0.113.9"}


@pytest.mark.parametrize("trusted", [(), ("127.0.0.1",)])
def test_a_proxy_that_is_not_trusted_is_named_once(
    caplog: pytest.LogCaptureFixture, trusted: tuple[str, ...]
) -> None:
    with serving(trusted_proxies=trusted) as server, server.client() as http:
        for headers in (WHO, WHO, {}):
            assert http.get("/healthz", headers=headers).is_success
    told = [each.getMessage() for each in caplog.records if each.levelno == logging.WARNING]
    named = [each for each in told if "X-Forwarded-For" in each]
    assert len(named) == (0 if trusted else 1)
    for said in () if trusted else ("from 127.0.0.1 is ignored", "--trusted-proxies"):
        assert said in named[0]


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
