"""Which addresses count as one client, also behind proxies, and how many connections it has."""

import pytest

from plinko.app.errors import BusyError, SettingError
from plinko.app.web.edge.addresses import Connections, Proxies, one_client


def test_an_ipv6_subscriber_is_one_client_an_ipv4_address_and_any_other_text_too() -> None:
    assert one_client("2001:db8:0:7::1") == one_client("2001:db8:0:7:ffff::2")
    assert one_client("2001:db8:0:7::1") != one_client("2001:db8:0:8::1")
    assert one_client("192.0.2.7") == one_client("::ffff:192.0.2.7") == "192.0.2.7"
    for host in ("192.0.2.8", "", "testclient", "/run/plinko.sock"):
        assert one_client(host) == host


def test_each_client_has_its_own_limit_of_connections() -> None:
    connections = Connections(2, Proxies(()))
    assert [connections.enter("192.0.2.7") for _ in range(3)] == [True, True, False]
    assert connections.enter("192.0.2.8")
    connections.leave("192.0.2.7")
    assert connections.enter("192.0.2.7")
    assert len(connections) == 3


def test_what_has_ended_leaves_nothing_behind() -> None:
    connections = Connections(2, Proxies(()))
    for number in range(1000):
        host = f"192.0.2.{number % 250}"
        assert connections.enter(host)
        connections.leave(host)
    assert len(connections) == 0
    assert not connections._open


def test_many_addresses_together_leave_some_for_others() -> None:
    connections = Connections(50, Proxies(["10.0.0.0/8"]), 100)
    taken = [sum(connections.enter(f"192.0.2.{n}") for _ in range(60)) for n in range(21)]
    assert taken[0] == 9
    assert sum(taken) < 100
    assert min(taken) >= 3
    assert connections.enter("192.0.2.99")
    while connections.enter("10.0.0.1"):
        pass
    assert len(connections) == 100
    assert isinstance(connections.refusal("192.0.2.100"), BusyError)
    connections.leave("10.0.0.1")
    assert connections.enter("192.0.2.100")


def test_a_trusted_proxy_speaks_for_many() -> None:
    connections = Connections(1, Proxies(["10.0.0.0/8", "2001:db8::1"]))
    assert all(connections.enter("10.1.2.3") for _ in range(5))
    assert all(connections.enter("2001:db8::1") for _ in range(5))
    assert [connections.enter("11.1.2.3") for _ in range(2)] == [True, False]
    assert "::ffff:10.0.0.2" in Proxies(["10.0.0.0/8"]), "on a socket for both kinds of addresses"
    with pytest.raises(SettingError, match="proxy\\.example"):
        Proxies(["proxy.example"])


@pytest.mark.parametrize(
    ("forwarded", "client"),
    [
        ("203.0.113.9", "203.0.113.9"),
        ("203.0.113.9:4711", "203.0.113.9"),
        ("[2001:db8::9]:4711", "2001:db8::9"),
        ("[2001:db8::9]", "2001:db8::9"),
        ("2001:DB8:0::9", "2001:db8::9"),
        ("192.0.2.66, 203.0.113.9, 10.0.0.2:99", "203.0.113.9"),
        ("10.0.0.3, [::ffff:10.0.0.2]:99", "10.0.0.3"),
        ("192.0.2.66, unknown", None),
        ("203.0.113.9:x", None),
        ("[2001:db8::9", None),
        ("", None),
    ],
)
def test_a_client_is_the_last_address_that_is_no_proxy_s(
    forwarded: str, client: str | None
) -> None:
    assert Proxies(["10.0.0.1/8"]).client_of(forwarded) == client
