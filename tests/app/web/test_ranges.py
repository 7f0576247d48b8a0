"""Films and pictures are sent in parts to clients that ask for parts, as Safari does for films."""

import httpx
import pytest

FILM = "/api/v1/drops/triangle-8/42.gif?width=320&fps=5"


@pytest.fixture(scope="module")
def whole(http: httpx.Client) -> httpx.Response:
    answer = http.get(FILM)
    assert answer.status_code == 200
    assert answer.headers["accept-ranges"] == "bytes"
    return answer


def asked(http: httpx.Client, part: str, **headers: str) -> httpx.Response:
    return http.get(FILM, headers={"range": part, **headers})


@pytest.mark.parametrize("kind", ["gif", "webp", "apng", "mp4", "png"])
def test_the_parts_of_a_film_make_the_whole(http: httpx.Client, kind: str) -> None:
    path = FILM.replace("gif", kind)
    path = path if kind != "png" else path.partition("&")[0]
    film = http.get(path, headers={"accept-encoding": "gzip"})
    assert "content-encoding" not in film.headers
    head = http.get(path, headers={"range": "bytes=0-1", "accept-encoding": "gzip"})
    rest = http.get(path, headers={"range": "bytes=2-", "if-range": film.headers["etag"]})
    assert (head.status_code, rest.status_code) == (206, 206)
    assert head.headers["content-range"] == f"bytes 0-1/{len(film.content)}"
    assert head.content + rest.content == film.content
    assert head.headers["etag"] == rest.headers["etag"] == film.headers["etag"]
    assert head.headers["content-type"] == film.headers["content-type"]
    assert rest.headers["content-length"] == str(len(film.content) - 2)


def test_a_part_is_the_bytes_from_the_first_to_the_last(
    http: httpx.Client, whole: httpx.Response
) -> None:
    size = len(whole.content)
    for part, first, last in (
        ("bytes=3-5", 3, 5),
        ("Bytes = 3-5", 3, 5),
        ("bytes=3-99999999999999999999999", 3, size - 1),
        ("bytes=-4", size - 4, size - 1),
        ("bytes=-99999999999999999999999", 0, size - 1),
    ):
        answer = asked(http, part)
        assert answer.status_code == 206, part
        assert answer.headers["content-range"] == f"bytes {first}-{last}/{size}"
        assert answer.content == whole.content[first : last + 1]


def test_what_asks_for_no_single_part_or_of_another_version_gets_the_whole(
    http: httpx.Client, whole: httpx.Response
) -> None:
    no_part = ("5-3", "99999999-5", "-", "a-b", "0-1,3-4", "1")
    for part in (*(f"bytes={each}" for each in no_part), "lines=0-1", ""):
        answer = asked(http, part)
        assert (answer.status_code, answer.content) == (200, whole.content), part
    etag = whole.headers["etag"]
    for known in ('"another"', f"W/{etag}", "Sat, 01 Jan 2000 00:00:00 GMT"):
        assert asked(http, "bytes=0-1", **{"if-range": known}).status_code == 200, known
    # What the client has already is not sent in parts, and a HEAD has none.
    assert asked(http, "bytes=0-1", **{"if-none-match": etag}).status_code == 304
    answer = http.head(FILM, headers={"range": "bytes=0-1"})
    assert answer.status_code == 200
    assert answer.headers["content-length"] == str(len(whole.content))


@pytest.mark.parametrize("part", ["bytes=99999999-", "bytes=-0"])
def test_a_part_that_is_not_there_is_refused_with_the_size(
    http: httpx.Client, whole: httpx.Response, part: str
) -> None:
    answer = asked(http, part)
    assert answer.status_code == 416
    assert answer.headers["content-range"] == f"bytes */{len(whole.content)}"
    problem = answer.json()
    assert (problem["code"], problem["field"]) == ("no-such-range", "range")
    assert part in problem["detail"]
