"""Settings: one table; environment, then flags; a value out of range is named."""

import dataclasses
from pathlib import Path

import pytest

from app.errors import SettingError
from app.settings import Settings, options, static_directory, table
from engine import Board, drop

DOCS = Path(__file__).parents[2] / "docs" / "api.md"


def test_flags_win_over_the_environment_and_both_over_the_defaults() -> None:
    environ = {"PLINKO_PORT": "9000", "PLINKO_HOST": "0.0.0.0", "HOME": "x"}
    settings = Settings.load(environ, {"port": 9001, "board": None})
    assert (settings.port, settings.host, settings.board) == (9001, "0.0.0.0", "triangle-16")
    assert Settings.load({}) == Settings()


def test_lists_are_comma_separated() -> None:
    environ = {"PLINKO_ALLOWED_ORIGINS": "https://a.example, https://b.example,"}
    assert Settings.load(environ).allowed_origins == ("https://a.example", "https://b.example")


def test_an_orchestrators_own_variables_are_left_alone() -> None:
    assert Settings.load({"PLINKO_SERVICE_HOST": "10.0.0.1"}) == Settings()


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
        ("PLINKO_TICK_RATE", "0", "tick_rate=0"),
        ("PLINKO_TRANSPORT", "fast", "transport='fast' is not one of: auto, direct, public"),
        ("PLINKO_LOG_FORMAT", "xml", "log_format='xml' is not one of: text, json"),
    ],
)
def test_a_bad_value_is_named_with_what_would_be_right(variable: str, text: str, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        Settings.load({variable: text})


def test_wrong_types_and_unknown_flags_are_refused() -> None:
    with pytest.raises(SettingError, match="port=True"):
        Settings(port=True)
    with pytest.raises(SettingError, match="port='8000'"):
        Settings.load({}, {"port": "8000"})
    with pytest.raises(SettingError, match="'prot' is not a setting"):
        Settings.load({}, {"prot": 8000})


def test_the_table_has_every_setting_and_the_documentation_has_the_table() -> None:
    assert [row.name for row in options()] == [field.name for field in dataclasses.fields(Settings)]
    assert table() in DOCS.read_text()


def test_the_page_is_found() -> None:
    assert static_directory().name == "static"


def test_the_documented_drop_is_the_engines_own() -> None:
    assert f'etag: "{drop(Board.preset("triangle-8"), 42).digest}"' in DOCS.read_text()
