"""The static site has a server's replies as files, and a server's pages but for a few modules."""

import json
from pathlib import Path

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.settings import static_directory
from plinko.app.web.page.languages import languages_of
from plinko.app.web.site import releases_in, write_site
from tests.kit.process import ServerProcess

STATIC = static_directory()


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    write_site(STATIC, folder)
    return folder


def test_files_have_the_replies_of_a_server(site: Path, tmp_path: Path) -> None:
    (release,) = releases_in(site)
    with ServerProcess(f"sqlite:///{tmp_path}/plinko.db") as server:
        for path in ("boards", "boards/moon-12-high", "boards/classic/odds"):
            reply = httpx.get(f"{server.url}/api/v1/{path}")
            assert (release / f"api/v1/{path}.json").read_bytes() == reply.content
    listed = json.loads((release / "api/v1/boards.json").read_bytes())["boards"]
    assert len(list((release / "api/v1/boards").glob("*.json"))) == len(listed) == 218


def test_modules_of_the_device_take_the_place_of_the_servers(site: Path) -> None:
    (release,) = releases_in(site)
    others = [path.relative_to(STATIC) for path in STATIC.rglob("*.device.js")]
    assert len(others) == 4
    for path in others:
        name = path.with_name(path.name.replace(".device.", "."))
        assert (STATIC / name).is_file(), f"{path} takes no module's place"
        assert (release / name).read_text() == (STATIC / path).read_text()
    for script in release.glob("js/play/all.*.js"):
        assert "WebSocket" not in script.read_text()


def test_texts_of_the_device_are_known_and_in_every_language() -> None:
    texts = json.loads((STATIC / "js/texts/device.json").read_text())
    known = languages_of(STATIC)
    assert set(texts) == set(known)
    assert len({tuple(changed) for changed in texts.values()}) == 1
    for language, changed in texts.items():
        assert set(changed) <= set(known[language])


def test_each_language_but_english_has_a_folder_of_the_same_pages(site: Path) -> None:
    pages = {path.name for path in site.glob("*.html")}
    assert pages == {
        f"{name}.html"
        for name in ["class", "editor", "index", "replay", "sandbox", "today", "verify"]
    }
    for folder in ("de", "es"):
        assert {path.name for path in (site / folder).iterdir()} == pages
    assert 'href="../manifest.json"' in (site / "de/index.html").read_text()


def test_a_site_is_replaced_and_other_files_are_not(
    site: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    former = site / f"v-{'0' * 16}"
    former.mkdir()
    assert main(["site", str(site)]) == 0
    assert len(releases_in(site)) == 1
    assert not former.exists()
    (tmp_path / "notes.txt").touch()
    assert main(["site", str(tmp_path)]) == 2
    assert "has other files: give a new folder, or one with a site" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
