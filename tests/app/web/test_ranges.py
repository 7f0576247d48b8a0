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


@pytest.mark.parametrize(
    ("part", "first", "last"),
    [
        ("bytes=3-5", 3, 5),
        ("Bytes = 3-5", 3, 5),
        ("bytes=3-99999999999999999999999", 3, -1),
        ("bytes=-4", -4, -1),
        ("bytes=-99999999999999999999999", 0, -1),
    ],
)
def test_a_part_is_the_bytes_from_the_first_to_the_last(
    http: httpx.Client, whole: httpx.Response, part: str, first: int, last: int
) -> None:
    size = len(whole.content)
    first, last = first % size, last % size
    answer = asked(http, part)
    assert answer.status_code == 206
    assert answer.headers["content-range"] == f"bytes {first}-{last}/{size}"
    assert answer.content == whole.content[first : last + 1]


@pytest.mark.parametrize(
    "part",
    [
        "bytes=5-3",
        "bytes=99999999-5",
        "bytes=-",
        "bytes=a-b",
        "bytes=0-1,3-4",
        "lines=0-1",
        "bytes=1",
        "",
    ],
)
def test_what_asks_for_no_single_part_gets_the_whole(
    http: httpx.Client, whole: httpx.Response, part: str
) -> None:
    answer = asked(http, part)
    assert (answer.status_code, answer.content) == (200, whole.content)


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


@pytest.mark.parametrize("known", ['"another"', "W/{}", "Sat, 01 Jan 2000 00:00:00 GMT"])
def test_a_part_of_another_version_is_the_whole(
    http: httpx.Client, whole: httpx.Response, known: str
) -> None:
    known = known.format(whole.headers["etag"])
    assert asked(http, "bytes=0-1", **{"if-range": known}).status_code == 200


def test_what_the_client_has_already_is_not_sent_in_parts(
    http: httpx.Client, whole: httpx.Response
) -> None:
    known = {"if-none-match": whole.headers["etag"]}
    assert asked(http, "bytes=0-1", **known).status_code == 304


def test_a_head_has_no_parts(http: httpx.Client, whole: httpx.Response) -> None:
    answer = http.head(FILM, headers={"range": "bytes=0-1"})
    assert answer.status_code == 200
    assert answer.headers["content-length"] == str(len(whole.content))
