"""The language of a page, and its texts."""

import pytest

from plinko.app.web.page.languages import chosen, filled, languages_of
from plinko.app.web.page.release import assembled
from tests.app.web.page.site import STATIC, site

THERE = ("en", "de", "es")


@pytest.mark.parametrize(
    ("cookie", "accepted", "language"),
    [
        (None, "", "en"),
        (None, "de-AT,de;q=0.9,en;q=0.8", "de"),
        (None, "en;q=0.5, es-419 ; q=0.7", "es"),
        (None, "fr-FR, fr;q=0.9, ES;q=0.1", "es"),
        (None, "de;q=0, *", "en"),
        (None, ";;,=q, de;q=nonsense", "de"),
        ("es", "de", "es"),
        ("xx", "de", "de"),
        ("../de", "", "en"),
    ],
)
def test_a_page_has_the_chosen_language_or_the_best_read_one(
    cookie: str | None, accepted: str, language: str
) -> None:
    assert chosen(accepted, THERE, cookie=cookie) == language


def test_the_language_in_an_address_is_the_page_s_without_cookies() -> None:
    assert chosen("en", THERE, address="de") == "de"
    assert chosen("en", THERE, address="es", cookie="de") == "es"
    assert chosen("es", THERE, address="../de") == "es"


def test_texts_are_escaped_and_elements_within_them_are_kept() -> None:
    page = '<b title="{{a}}">{{a}}</b> {{b|<i id="x">{{a}}</i>}}'
    told = filled(page, {"a": '1 < "2"', "b": "of {} & more"})
    said = "1 &lt; &quot;2&quot;"
    assert told == f'<b title="{said}">{said}</b> of <i id="x">{said}</i> &amp; more'
    # A text that is not there is named.
    with pytest.raises(ValueError, match=r"uses the text 'no\.such'"):
        filled("<p>{{no.such}}</p>", {"such": "", "no.such": {"other": ""}})


def test_every_page_has_every_text_in_every_language() -> None:
    languages = languages_of(STATIC)
    assert tuple(languages) == THERE
    for page in STATIC.glob("*.html"):
        for texts in languages.values():
            whole = assembled(STATIC, page.name, page.read_text("utf-8"))
            assert "{{" not in filled(whole, texts)


async def test_caches_learn_which_headers_a_page_depends_on() -> None:
    async with site() as pages:
        marks = set()
        for language in THERE:
            answer = await pages.get("/", headers={"accept-language": language})
            assert f'<html lang="{language}"' in answer.text
            assert f"/js/play/all.{language}.js" in answer.text
            assert "accept-language, cookie" in answer.headers["vary"].lower()
            marks.add(answer.headers["etag"])
        assert len(marks) == len(THERE)
        again = {"accept-language": language, "if-none-match": answer.headers["etag"]}
        assert (await pages.get("/", headers=again)).status_code == 304
        shown = await pages.get("/?language=es", headers={"accept-language": "de"})
        assert '<html lang="es"' in shown.text
        chosen_since = {**again, "cookie": "language=de"}
        assert (await pages.get("/", headers=chosen_since)).status_code == 200
