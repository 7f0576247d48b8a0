"""The operator's list of webhook targets is read at the start; errors give the reason."""

import base64
from pathlib import Path
from typing import cast

import msgspec
import pytest

from plinko.app.errors import SettingError
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.webhooks.sender import Webhooks
from plinko.app.webhooks.targets import Target, names_of, read_targets

SECRET = "whsec_" + base64.b64encode(b"s" * 32).decode()


def listed(folder: Path, *targets: object) -> str:
    file = folder / "webhooks.json"
    file.write_bytes(msgspec.json.encode(targets))
    return str(file)


def test_a_file_lists_addresses_with_their_secrets(tmp_path: Path) -> None:
    url = "https://example.org/hook"
    assert read_targets(listed(tmp_path, {"url": url, "secret": SECRET})) == (Target(url, SECRET),)


def test_no_file_is_no_target() -> None:
    assert read_targets("") == ()


@pytest.mark.parametrize(
    ("target", "why"),
    [
        ({"url": "ftp://example.org", "secret": SECRET}, "an address must be a URL such as"),
        ({"url": "http:///hook", "secret": SECRET}, "an address must be a URL such as"),
        ({"url": "http://example.org:", "secret": SECRET}, "example.org:: the port must be"),
        ({"url": "http://example.org:/hook", "secret": SECRET}, "example.org:: the port must be"),
        ({"url": "http://example.org:0/", "secret": SECRET}, "example.org:0: the port must be"),
        ({"url": "http://me:pw@example.org:x/", "secret": SECRET}, "'.*: example.org:x: the port"),
        ({"url": "http://example.org:65536", "secret": SECRET}, "example.org:65536: the port"),
        ({"url": "http://example.org", "secret": "short"}, "must begin with whsec_"),
        ({"url": "http://example.org", "secret": "whsec_?"}, "base64"),
        ({"url": "http://example.org", "secret": "whsec_YWJj"}, "24 to 64 bytes, not 3"),
        ({"url": "http://example.org"}, "missing required field `secret`"),
        ({"url": "http://example.org", "secret": SECRET, "rooms": []}, "unknown field `rooms`"),
    ],
)
def test_a_target_that_cannot_be_used_is_refused_with_the_reason(
    target: object, why: str, tmp_path: Path
) -> None:
    with pytest.raises(SettingError, match=why) as raised:
        read_targets(listed(tmp_path, target))
    assert raised.value.field == "webhooks"


def test_an_address_is_listed_once(tmp_path: Path) -> None:
    target = {"url": "http://example.org", "secret": SECRET}
    with pytest.raises(SettingError, match="two targets have the same address"):
        read_targets(listed(tmp_path, target, target))


def test_a_key_is_given_once(tmp_path: Path) -> None:
    file = tmp_path / "webhooks.json"
    url = '"url": "http://example.org"'
    file.write_text(f'[{{{url}, {url}, "secret": "{SECRET}"}}]')
    with pytest.raises(SettingError, match=r"\[0\]\.url: the key is given twice"):
        read_targets(str(file))


def test_a_file_that_is_not_there_is_named() -> None:
    with pytest.raises(SettingError, match=r"webhooks='none\.json'.*No such file"):
        read_targets("none.json")


def test_a_target_s_name_reveals_no_secret(tmp_path: Path) -> None:
    file = listed(tmp_path, {"url": "https://me:word@example.org:8443/t0ken", "secret": SECRET})
    (target,) = read_targets(file)
    assert names_of([target]) == ["example.org:8443"]
    assert repr(target) == "Target('example.org:8443')"


def test_two_targets_at_one_host_are_two_in_metrics_and_logs() -> None:
    urls = ("https://a.test/1", "https://b.test/", "https://me:word@a.test/2", "https://a.test:8/")
    targets = [Target(url, SECRET) for url in urls]
    assert names_of(targets) == ["a.test", "b.test", "a.test (2)", "a.test:8"]
    hooks = Webhooks(targets, cast(Ledger, None), lambda: True)
    labels = [labels["target"] for _, _, _, labels in hooks.readings()]
    assert labels == names_of(targets)
