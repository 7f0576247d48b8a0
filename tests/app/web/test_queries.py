"""Query parameters: numbers are decimal, and values are checked before they are used."""

from urllib.parse import quote

import httpx
import pytest

DROP = "/api/v1/drops/triangle-8/42"
HUGE = "9" * 30


def named(http: httpx.Client, path: str, field: str) -> None:
    refused = http.get(path)
    assert (refused.status_code, refused.json()["field"]) == (422, field), refused.text


@pytest.mark.parametrize("spelt", ["0_0.1", "1e-1_0", "0.1\n", " 0.1", "0.1 ", "٠.١", "nan", "inf"])
@pytest.mark.parametrize(
    ("path", "field"),
    [
        (f"{DROP}?x=", "x"),
        (f"{DROP}?aim=", "aim"),
        (f"{DROP}?solver=stepped&dt=", "dt"),
        (f"{DROP}.png?t=", "t"),
        (f"{DROP}/frames?fps=", "fps"),
    ],
)
def test_a_number_is_a_plain_decimal(http: httpx.Client, path: str, field: str, spelt: str) -> None:
    named(http, path + quote(spelt), field)


@pytest.mark.parametrize("spelt", ["1_0", "10\n", " 10", "١", "1.0", "1e1", ""])
@pytest.mark.parametrize(
    ("path", "field"),
    [
        (f"{DROP}?solver=stepped&substeps=", "substeps"),
        (f"{DROP}.png?width=", "width"),
        (f"{DROP}.gif?fps=", "fps"),
        ("/api/v1/boards/triangle-8/density.png?drops=", "drops"),
        ("/api/v1/boards/triangle-8/sheet.png?columns=", "columns"),
        ("/api/v1/rooms?limit=", "limit"),
        ("/api/v1/rooms/main/log?first=", "first"),
        ("/api/v1/rooms/main/stream.mjpg?fps=", "fps"),
        ("/api/v1/players/nobody/plays?limit=", "limit"),
        ("/api/v1/log?since=", "since"),
    ],
)
def test_a_whole_number_is_plain_digits(
    http: httpx.Client, path: str, field: str, spelt: str
) -> None:
    named(http, path + quote(spelt), field)


@pytest.mark.parametrize("x", ["0.05", "-0.05", "+0.05", ".05", "5e-2", "5E-02", "0"])
def test_decimals_as_people_and_programs_write_them_are_taken(http: httpx.Client, x: str) -> None:
    found = http.get(DROP, params={"x": x})
    assert found.json()["x"] == float(x)


@pytest.mark.parametrize(
    "path",
    [
        "/api/v1/log?since=",
        "/api/v1/rooms/main/log?first=",
        "/api/v1/rooms/main/log?limit=",
        "/api/v1/boards/triangle-8/density.png?seed=1&drops=",
    ],
)
def test_a_number_that_no_ledger_can_hold_is_refused(http: httpx.Client, path: str) -> None:
    assert http.get(path + HUGE).status_code == 422


PICTURES = [
    f"{DROP}.png",
    f"{DROP}.gif",
    f"{DROP}.mp4",
    "/api/v1/boards/triangle-8/density.png",
    "/api/v1/boards/triangle-8/histogram.png",
    "/api/v1/boards/triangle-8/sheet.png",
    "/api/v1/rooms/main/frame.png",
    "/api/v1/rooms/main/stream.mjpg",
]


@pytest.mark.parametrize("theme", ["", "blue", "Light", "light · Moon", "日本", "a\nb: c", "\x00"])
@pytest.mark.parametrize("path", PICTURES)
def test_a_theme_is_known_before_it_names_anything(
    http: httpx.Client, path: str, theme: str
) -> None:
    address = f"{path}?theme={quote(theme)}"
    named(http, address, "theme")
    whatever = http.get(address, headers={"if-none-match": "*"})  # would match any ETag
    assert whatever.status_code == 422


@pytest.mark.parametrize("width", ["-1", "0", "2049", HUGE])
@pytest.mark.parametrize("path", PICTURES)
def test_a_width_is_in_its_range_before_it_names_anything(
    http: httpx.Client, path: str, width: str
) -> None:
    named(http, f"{path}?width={width}", "width")
