"""The server answers only requests for its own host names."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.errors import HostError
from plinko.app.web.edge.hosts import Hosts, host_of


def allowed(hosts: Hosts, header: str | None) -> bool:
    try:
        hosts.check(header)
    except HostError:
        return False
    return True


OURS = (
    "localhost", "localhost:8000", "LOCALHOST", "localhost.", "game.localhost", "127.0.0.1:8000",
    "127.9.9.9", "[::1]:8000", "[::1]", None,
)  # fmt: skip
STRANGE = (
    "evil.example", "evil.example:8000", "localhost.evil.example", "127.0.0.1.evil.example",
    "localhostevil", "", " ", "[", "[::1", "::1", "[evil]", "a b", "localhost:x", "localhost:8:1",
    "http://localhost", "localhost/", "user@localhost", "evil.example#localhost", "-",
)  # fmt: skip


def test_this_machine_is_always_allowed_a_stranger_s_name_and_no_name_are_refused() -> None:
    for listening in ("127.0.0.1", "::1", "192.0.2.7", "0.0.0.0", "::"):
        for header in OURS:
            assert allowed(Hosts(listening, ()), header), (listening, header)
        for strange in STRANGE:
            with pytest.raises(HostError, match="not a name of this server; the setting `hosts`"):
                Hosts(listening, (), "box").check(strange)


def test_an_address_is_allowed_where_the_server_listens_on_it() -> None:
    assert allowed(Hosts("192.0.2.7", ()), "192.0.2.7:8000")
    assert not allowed(Hosts("192.0.2.7", ()), "192.0.2.8:8000")
    assert not allowed(Hosts("127.0.0.1", ()), "192.0.2.7:8000")
    assert allowed(Hosts("0.0.0.0", ()), "192.0.2.7:8000")
    assert allowed(Hosts("::", ()), "[2001:db8::1]:8000")


def test_a_machine_that_listens_everywhere_has_its_own_name() -> None:
    everywhere = Hosts("0.0.0.0", (), "Box.example.org")
    assert [allowed(everywhere, each) for each in ("box", "BOX.local:8000")] == [True, True]
    assert not allowed(everywhere, "box.example.org"), "such names are asked of the DNS"
    assert not allowed(Hosts("127.0.0.1", (), "box"), "box")


def test_only_configured_host_names_are_allowed() -> None:
    hosts = Hosts("127.0.0.1", ("plinko.example", "*.Play.example"))
    for good in ("plinko.example", "Plinko.Example.:443", "a.play.example", "a.b.play.example"):
        assert allowed(hosts, good), good
    for bad in ("a.plinko.example", "play.example", "evilplay.example", "plinko.example.evil"):
        assert not allowed(hosts, bad), bad
    assert allowed(Hosts("127.0.0.1", ("*",)), "whatever [ is")


@given(st.text(max_size=40))
def test_any_header_is_allowed_or_refused_and_nothing_else(header: str) -> None:
    allowed(Hosts("0.0.0.0", ("plinko.example",), "box"), header)
    host = host_of(header)
    assert host is None or host_of(f"[{host}]" if ":" in host else host) == host
