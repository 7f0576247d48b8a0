"""Settings come from the environment, then from flags; errors name the invalid value."""

import dataclasses
from pathlib import Path

import pytest

from plinko.app.errors import SettingError
from plinko.app.settings import Settings, not_settings, options, table


def test_flags_win_over_environment_and_both_over_defaults_and_lists_have_commas() -> None:
    environ = {"PLINKO_PORT": "9000", "PLINKO_HOST": "0.0.0.0", "HOME": "x"}
    settings = Settings.load(environ, {"port": 9001, "board": None})
    assert (settings.port, settings.host, settings.board) == (9001, "0.0.0.0", "triangle-16")
    assert Settings.load({}) == Settings()
    environ = {"PLINKO_ALLOWED_ORIGINS": "https://a.example, https://b.example,"}
    assert Settings.load(environ).allowed_origins == ("https://a.example", "https://b.example")


def test_a_misspelt_variable_is_named_an_orchestrator_s_is_not() -> None:
    assert Settings.load({"PLINKO_SERVICE_HOST": "10.0.0.1"}) == Settings()
    theirs = ("SERVICE_HOST", "SERVICE_PORT_HTTP", "PORT_8000_TCP", "PORT_8000_TCP_ADDR")
    environ = {f"PLINKO_{name}": "x" for name in (*theirs, "HOST", "SECRET", "SECRETS", "COLOUR")}
    assert not_settings(environ) == [
        "PLINKO_COLOUR in the environment is not a setting, and has no effect",
        "PLINKO_SECRETS in the environment is not a setting: did you mean PLINKO_SECRET?",
    ]


@pytest.mark.parametrize(
    ("variable", "text", "said"),
    [
        ("PLINKO_PORT", "abc", r"PLINKO_PORT='abc' is not a whole number from 0 to 65,535"),
        ("PLINKO_PORT", "tcp://10.0.0.1:8000", "PLINKO_PORT"),
        ("PLINKO_PORT", "65536", r"port=65536 is not a whole number from 0 to 65,535"),
        ("PLINKO_PORT", "1.5", "PLINKO_PORT"),
        ("PLINKO_DROP_RATE", "nan", "drop_rate=nan"),
        ("PLINKO_DROP_RATE", "-1", "drop_rate=-1"),
        ("PLINKO_HOST", "", "host=''"),
        ("PLINKO_ROOT_PATH", "plinko", "root_path='plinko' is not a path such as /plinko"),
        ("PLINKO_ROOT_PATH", "/plinko/", "root_path='/plinko/'"),
        ("PLINKO_ROOT_PATH", "/api", "root_path='/api'"),
        ("PLINKO_HOSTS", "https://a.example", "hosts='https://a.example' is not a host name"),
        ("PLINKO_HOSTS", "a.example,b:8000", "hosts='b:8000' is not"),
        ("PLINKO_ALLOWED_ORIGINS", "a.example", "'a.example' is not an origin such as https://"),
        ("PLINKO_ALLOWED_ORIGINS", "https://a.example/", "'https://a.example/' is not an origin"),
        (
            "PLINKO_ADDRESS",
            "10.0.0.1:8000",
            "address='10.0.0.1:8000' is not an address such as http",
        ),
        ("PLINKO_RETENTION", "0.5", "retention=0.5 is less than a day; 0 keeps all drops"),
        ("PLINKO_METRICS_TOKEN", "short", "PLINKO_METRICS_TOKEN has 5 characters"),
        ("PLINKO_LOG_FORMAT", "xml", "log_format='xml' is not one of: text, json"),
    ],
)
def test_a_bad_value_is_named_with_what_would_be_right(variable: str, text: str, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        Settings.load({variable: text})


def test_a_secret_has_no_flag_and_is_never_shown() -> None:
    settings = Settings.load({"PLINKO_SECRET": "quiet" * 8})
    assert settings.secret == "quiet" * 8
    assert "quiet" not in repr(settings)
    (row,) = [row for row in options() if row.name == "secret"]
    assert row.flag == ""
    with pytest.raises(
        SettingError, match="PLINKO_SECRET has 5 characters; it must have at least 32"
    ) as raised:
        Settings.load({"PLINKO_SECRET": "quiet"})
    assert "quiet" not in str(raised.value)


def test_a_host_is_a_name_a_pattern_or_an_address() -> None:
    for host in ("a.example", "*.a.example", "*", "10.0.0.1", "fd00::1", "a_b"):
        assert Settings.load({"PLINKO_HOSTS": host}).hosts == (host,)


@pytest.mark.parametrize("name", ["secret", "metrics_token", "operator_token", "database_url"])
def test_a_secret_may_be_in_a_file_or_a_credential(name: str, tmp_path: Path) -> None:
    value = "sqlite:///of-32-characters-and-more.db"
    file, variable = tmp_path / f"plinko.{name}", f"PLINKO_{name.upper()}"
    file.write_text(f"{value}\n")
    assert getattr(Settings.load({f"{variable}_FILE": str(file)}), name) == value
    credentials = {"CREDENTIALS_DIRECTORY": str(tmp_path)}
    assert getattr(Settings.load(credentials), name) == value
    other = "sqlite:///another-of-32-characters.db"
    assert getattr(Settings.load({**credentials, variable: other}), name) == other
    with pytest.raises(SettingError, match=f"{variable} and {variable}_FILE are both set"):
        Settings.load({variable: other, f"{variable}_FILE": str(file)})
    with pytest.raises(SettingError, match=f"{name}: .*missing cannot be read: No such file"):
        Settings.load({f"{variable}_FILE": str(tmp_path / "missing")})
    assert not_settings({f"{variable}_FILE": "x"}) == []


def test_the_ledger_is_where_a_server_on_this_port_left_it() -> None:
    home = Path("~/.local/share/plinko").expanduser()
    assert Settings(port=8000).ledger_url == f"sqlite:///{home}/8000/plinko.db"
    assert Settings(port=0).ledger_url == "sqlite://", "a free port is another one each time"
    assert Settings(port=0, data="d").ledger_url == "sqlite:///d/plinko.db"
    assert Settings(data="d", database_url="sqlite://").ledger_url == "sqlite://"


def test_wrong_types_and_unknown_flags_are_refused() -> None:
    with pytest.raises(SettingError, match="port=True"):
        Settings(port=True)
    with pytest.raises(SettingError, match="port='8000'"):
        Settings.load({}, {"port": "8000"})
    with pytest.raises(SettingError, match="'prot' is not a setting"):
        Settings.load({}, {"prot": 8000})


def test_the_table_has_every_setting() -> None:
    assert [row.name for row in options()] == [field.name for field in dataclasses.fields(Settings)]
    assert all(f"| `{row.variable}` |" in table() for row in options())
