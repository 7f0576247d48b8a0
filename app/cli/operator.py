"""What who runs a server asks of it, with the operator's token."""

import json
import os
import urllib.error
import urllib.parse
import urllib.request
from typing import Any

from app.errors import SettingError

TOKEN = "PLINKO_OPERATOR_TOKEN"


def ask(url: str, path: str, body: dict[str, Any]) -> dict[str, Any]:
    """What the server at `url` answers to a POST; raises SettingError with what is wrong."""
    address = urllib.parse.urlsplit(url)
    if address.scheme not in ("http", "https") or not address.netloc:
        raise SettingError(f"{url!r} is not an address such as http://127.0.0.1:8000", field="url")
    headers = {"content-type": "application/json"}
    if token := os.environ.get(TOKEN):
        headers["authorization"] = f"Bearer {token}"
    asked = urllib.request.Request(
        f"{url.rstrip('/')}{path}", json.dumps(body).encode(), headers, method="POST"
    )
    try:
        with urllib.request.urlopen(asked) as answer:
            found: dict[str, Any] = json.load(answer)
            return found
    except urllib.error.HTTPError as refused:
        said = json.load(refused)
        raise SettingError(f"{url}: {said['detail']}", field="url") from refused
    except urllib.error.URLError as missing:
        raise SettingError(f"{url}: {missing.reason}", field="url") from missing
