"""All settings of the server in one table: default, range, environment name, flag, meaning."""

import difflib
import os
import re
from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from plinko.app.errors import SettingError

ENV_PREFIX = "PLINKO_"

TICK_RATE: Final = 60
"""Ticks and snapshots a second. Not a setting: with another one, all runs in the ledger end."""

OTHER_MESSAGES = 40.0
"""Messages a second that one client may send in addition to drops. A page sends about thirty while
its player drags a ball; a client that sends many more is not a page."""

_SECRET = 32  # characters: 128 bits even of a secret written in hexadecimal

_IN_FILES = ("secret", "metrics_token", "operator_token", "database_url", "relays")
"""Settings that are secrets or contain one: a file may have the value, in place of the environment.

PLINKO_NAME_FILE names the file. Without that variable it is systemd's credential `plinko.name`.
"""


def _setting(
    default: Any,
    text: str,
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    *,
    form: str = "",
    wanted: str = "",
    secret: bool = False,
) -> Any:
    """One setting; its text, or each text in its list, has the form of a regular expression.

    A secret has no flag: every user of the machine can read a process's flags.
    """
    rules: dict[str, Any] = {"text": text, "low": low, "high": high, "choices": choices}
    rules |= {"form": re.compile(form), "wanted": wanted, "secret": secret}
    return field(default=default, metadata=rules, repr=not secret)


@dataclass(frozen=True, slots=True)
class Settings:
    """All settings, validated at construction (raises SettingError)."""

    host: str = _setting("127.0.0.1", "address to listen on; 0.0.0.0 for every interface")
    port: int = _setting(8000, "port to listen on; 0 takes a free one", 0, 65535)
    board: str = _setting("triangle-16", "board of the room `main`: a preset's name or a JSON file")
    allowed_origins: tuple[str, ...] = _setting(
        (),
        "comma-separated origins of other sites whose pages may connect",
        form=r"[a-z][a-z\d+.-]*://[^/?#\s]+",
        wanted="an origin such as https://plinko.example: it has a scheme, and no path",
    )
    hosts: tuple[str, ...] = _setting(
        (),
        "comma-separated names under which the server answers, in addition to `localhost` and the "
        "address that it listens on; `*.example.org` for all names below, `*` for any",
        form=r"\*|(\*\.)?[\w.-]+|([\da-fA-F.]*:){2,}[\da-fA-F.]*",  # also IPv6
        wanted="a host name: give it without scheme, port and path, such as plinko.example",
    )
    trusted_proxies: tuple[str, ...] = _setting(
        (),
        "comma-separated addresses or networks of proxies whose `X-Forwarded-For` names the client",
    )
    root_path: str = _setting(
        "",
        "path, such as `/plinko`, that a proxy removes from requests and that the server adds to "
        "the addresses it writes",
        form=r"(?!/(api|ws)(/|$))(/[\w.~-]+)+",
        wanted="a path such as /plinko: it must begin with a slash, end without one, and not begin "
        "with /api or /ws",
    )
    data: str = _setting(
        "",
        "directory of the ledger's file and of the server's secret; "
        "`~/.local/share/plinko/PORT` when not given",
    )
    database_url: str = _setting(
        "",
        "the ledger: `sqlite:///FILE`, `postgresql://USER@HOST/NAME`, or `sqlite://` to keep it in "
        "memory; `plinko.db` in the data directory when not given, in memory with port 0",
    )
    relays: str = _setting(
        "",
        "Redis through which relays receive the events of rooms: `redis://HOST:6379`; none when "
        "not given",
    )
    name: str = _setting(
        "",
        "name of this server among several that share one ledger on PostgreSQL; when not given, "
        "no other server may use its ledger",
    )
    address: str = _setting(
        "",
        "address at which those servers reach this one: `http://HOST:PORT`; the address that it "
        "listens on when not given",
        form=r"https?://.+",
        wanted="an address such as http://10.0.0.1:8000",
    )
    secret: str = _setting(
        "",
        "secret that signs the tokens of rooms, at least 32 characters; when not given, the server "
        "makes one and keeps it next to the ledger",
        secret=True,
    )
    metrics_token: str = _setting(
        "",
        "token that `/metrics` requires, as `Authorization: Bearer TOKEN`, at least 32 characters; "
        "when not given, everybody may read it",
        secret=True,
    )
    operator_token: str = _setting(
        "",
        "the operator's token, which halts tables, bans clients and announces over REST, as "
        "`Authorization: Bearer TOKEN`, at least 32 characters; when not given, nobody can",
        secret=True,
    )
    retention: float = _setting(
        0.0,
        "days after which landed drops are deleted, with their results and receipts, except those "
        "of open fair sessions; 0 keeps them, otherwise at least 1",
        0,
        36_500,
    )
    webhooks: str = _setting(
        "",
        "JSON file of the addresses that receive each drop and landing, with their secrets: see "
        "docs/stage.md",
    )
    address_connections: int = _setting(
        500, "open connections of one address; no limit for a trusted proxy", 1, 1_000_000
    )
    drop_rate: float = _setting(20.0, "drops a second from one client", 0.1, 1e6)
    max_balls: int = _setting(200, "balls in flight in one room", 1, 65535)
    max_clients: int = _setting(1000, "clients in one room", 1, 1_000_000)
    max_rooms: int = _setting(
        1000,
        "rooms created by players, open at once; rooms idle for an hour close for new ones; one "
        "address may create a tenth of the free places",
        1,
        1_000_000,
    )
    workers: int = _setting(2, "processes for drops, pictures and board checks", 1, 256)
    log_format: str = _setting(
        "text", "`text` for people or `json`, one object a line", choices=("text", "json")
    )
    log_level: str = _setting(
        "warning",
        "least level logged: `debug`, `info`, `warning` or `error`",
        choices=("debug", "info", "warning", "error"),
    )

    def __post_init__(self) -> None:
        for entry in fields(self):
            _check(entry, getattr(self, entry.name))
        if 0.0 < self.retention < 1.0:
            raise SettingError(
                f"retention={self.retention:g} is less than a day; 0 keeps all drops",
                field="retention",
            )

    @property
    def changed(self) -> dict[str, object]:
        """The settings that differ from their defaults, without those that may contain a secret."""
        return {
            entry.name: value
            for entry in fields(self)
            if entry.name not in _IN_FILES and (value := getattr(self, entry.name)) != entry.default
        }

    @property
    def message_rate(self) -> float:
        """Messages a second from one client: its drops and all other messages."""
        return self.drop_rate + OTHER_MESSAGES

    @property
    def data_directory(self) -> Path | None:
        """The directory of the server's files; None if it stores none."""
        if self.data:
            return Path(self.data).expanduser()
        # Port 0 is another free port each time: the next start would not find the directory.
        if self.port == 0:
            return None
        return Path("~/.local/share/plinko").expanduser() / str(self.port)

    @property
    def ledger_url(self) -> str:
        if self.database_url:
            return self.database_url
        directory = self.data_directory
        return "sqlite://" if directory is None else f"sqlite:///{directory / 'plinko.db'}"

    @property
    def epoch_file(self) -> Path | None:
        """The file with this server's epoch, unless SQLite's file determines it."""
        directory = self.data_directory
        return None if directory is None else directory / "epoch"

    @classmethod
    def load(
        cls,
        environ: Mapping[str, str] | None = None,
        overrides: Mapping[str, object] | None = None,
    ) -> "Settings":
        """Settings from PLINKO_* variables, files of secrets, then `overrides` (flags) if not None.

        Raises SettingError naming the variable or flag. It ignores unknown PLINKO_* variables, on
        which `not_settings` reports.
        """
        environ = os.environ if environ is None else environ
        known = {entry.name: entry for entry in fields(cls)}
        values: dict[str, Any] = {}
        for variable, text in environ.items():
            name = variable.removeprefix(ENV_PREFIX).lower()
            if variable.startswith(ENV_PREFIX) and name in known:
                values[name] = _parse(known[name], text, variable)
        for name in _IN_FILES:
            if (file := _file_of(name, environ)) is not None:
                if name in values:
                    variable = ENV_PREFIX + name.upper()
                    raise SettingError(
                        f"{variable} and {variable}_FILE are both set: set only one", field=name
                    )
                values[name] = _read(name, file)
        for name, value in (overrides or {}).items():
            if name not in known:
                raise SettingError(f"{name!r} is not a setting", field=name)
            if value is not None:
                values[name] = value
        return cls(**values)


def _file_of(name: str, environ: Mapping[str, str]) -> Path | None:
    """The file that has the value of a setting; None if there is none."""
    variable = ENV_PREFIX + name.upper()
    if f"{variable}_FILE" in environ:
        return Path(environ[f"{variable}_FILE"])
    if variable in environ or "CREDENTIALS_DIRECTORY" not in environ:
        return None
    credential = Path(environ["CREDENTIALS_DIRECTORY"], f"plinko.{name}")
    return credential if credential.exists() else None


def _read(name: str, file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, UnicodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8"
        raise SettingError(f"{name}: {file} cannot be read: {reason}", field=name) from error


def _parse(entry: "Field[Any]", text: str, variable: str) -> object:
    """`text` as the type of the setting's default."""
    kind: Any = type(entry.default)
    if kind is tuple:
        return tuple(part.strip() for part in text.split(",") if part.strip())
    try:
        return kind(text)
    except ValueError:
        raise SettingError(
            f"{variable}={text!r} is not {_wanted(entry)}", field=entry.name
        ) from None


def _check(entry: "Field[Any]", value: Any) -> None:
    """Raise SettingError unless `value` has the setting's type and is in its range."""
    kind: Any = type(entry.default)
    good = isinstance(value, kind) or (kind is float and isinstance(value, int))
    low, high = entry.metadata["low"], entry.metadata["high"]
    if good and low is not None:
        # Written so that NaN, which compares false with everything, is refused.
        good = not isinstance(value, bool) and low <= value <= high
    choices = entry.metadata["choices"]
    empty = value == "" and entry.default != ""
    if not good or empty or (choices and value not in choices):
        raise SettingError(f"{entry.name}={value!r} is not {_wanted(entry)}", field=entry.name)
    if entry.metadata["secret"] and 0 < len(value) < _SECRET:
        raise SettingError(
            f"{ENV_PREFIX}{entry.name.upper()} has {len(value)} characters; it must have at least "
            f"{_SECRET}",
            field=entry.name,
        )
    if wanted := entry.metadata["wanted"]:
        for part in value if kind is tuple else filter(None, [value]):
            if not entry.metadata["form"].fullmatch(part):
                raise SettingError(f"{entry.name}={part!r} is not {wanted}", field=entry.name)


def _wanted(entry: "Field[Any]") -> str:
    names = {int: "a whole number", float: "a number", str: "a text", tuple: "a list of texts"}
    if entry.metadata["choices"]:
        return "one of: " + ", ".join(entry.metadata["choices"])
    wanted = names[type(entry.default)]
    low, high = entry.metadata["low"], entry.metadata["high"]
    return wanted if low is None else f"{wanted} from {low:,g} to {high:,g}"


_ORCHESTRATORS = re.compile(
    r"SERVICE_(HOST|PORT\w*)|PORT_\d+_\w+|PORT_(TCP|UDP)\w*|ENV_\w+|TEST_\w+"
)
"""Variables that orchestrators set for a service called plinko, and those of the tests."""


def not_settings(environ: Mapping[str, str]) -> list[str]:
    """A warning for each PLINKO_ variable that nothing reads, with the setting probably meant."""
    known = [row.variable for row in options()]
    known += [f"{ENV_PREFIX}{name.upper()}_FILE" for name in _IN_FILES]
    found = []
    for variable in sorted(environ):
        name = variable.removeprefix(ENV_PREFIX)
        if not variable.startswith(ENV_PREFIX) or variable in known:
            continue
        if _ORCHESTRATORS.fullmatch(name) is None:
            meant = difflib.get_close_matches(variable, known, 1, 0.85)
            hint = f": did you mean {meant[0]}?" if meant else ", and has no effect"
            found.append(f"{variable} in the environment is not a setting{hint}")
    return found


@dataclass(frozen=True, slots=True)
class Option:
    """A row of the table of settings, from which flags and documentation are made.

    `flag` is empty for a setting that only the environment sets.
    """

    name: str
    variable: str
    flag: str
    default: Any
    text: str


def options() -> tuple[Option, ...]:
    """The table of settings, in order."""
    return tuple(
        Option(
            entry.name,
            ENV_PREFIX + entry.name.upper(),
            "" if entry.metadata["secret"] else "--" + entry.name.replace("_", "-"),
            entry.default,
            entry.metadata["text"],
        )
        for entry in fields(Settings)
    )


def table() -> str:
    """The table of settings in Markdown, which the site shows in docs/server.md."""
    lines = ["| flag of `plinko serve` | environment | default | meaning |", "|---|---|---|---|"]
    for row in options():
        shown = ",".join(row.default) if isinstance(row.default, tuple) else str(row.default)
        flag, default = (f"`{cell}`" if cell else "" for cell in (row.flag, shown))
        lines.append(f"| {flag} | `{row.variable}` | {default} | {row.text} |")
    return "\n".join(lines) + "\n"


def static_directory() -> Path:
    """The directory of the pages' files."""
    return Path(__file__).resolve().parents[1] / "static"


def page_kernels() -> Path:
    """The file of the exact solver that pages load; a fair session names it as its kernel."""
    return static_directory() / "js" / "solver" / "kernels.wasm"
