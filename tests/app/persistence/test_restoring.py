"""A restored backup: a start refuses it, `plinko ledger restore` ends what is unfair, play goes on.

A player has seen drops that the backup lacks, and has seen the
secret of a session that is still open in the backup.
"""

import contextlib
import hashlib
import io
import json
import runpy
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.cli.server.serve import restore_if_refused
from plinko.app.errors import SettingError
from plinko.app.fairness.check import Verdict, check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.fairness.signing import is_signed
from plinko.app.main import create_app, open_ledger
from plinko.app.settings import Settings, page_kernels
from plinko.engine import merkle
from tests.app.conftest import QUICK
from tests.app.persistence.conftest import (
    POSTGRESQL,
    SQLITE,
    new_database,
    on_sqlite,
    on_sqlite_first,
)
from tests.kit.player import playing
from tests.kit.serving import Running, serving

SEED = b"\x51" * 32
KERNEL = kernel_digest_of(page_kernels().read_bytes())
KEYED = {"idempotency-key": "K"}
VERIFIER = Path(__file__).parents[3] / "examples" / "verify_session.py"


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


def done(*command: str) -> None:
    finished = run(*command)
    assert finished.returncode == 0, finished.stderr


@dataclass
class Session:
    id: str
    room: str
    shown: dict[str, str]
    statement: dict[str, Any]


@dataclass
class Visit:
    """A player of a running server."""

    http: httpx.Client
    server: Running

    def post(self, path: str, body: object = None, **options: Any) -> dict[str, Any]:
        reply = self.http.post(path, json=body, **options)
        assert reply.is_success, reply.text
        found: dict[str, Any] = reply.json()
        return found

    def room(self) -> tuple[str, dict[str, str]]:
        made = self.post("/rooms", {"board": QUICK})
        return made["id"], {"authorization": f"Bearer {made['token']}"}

    def session(self, room: str) -> Session:
        made = self.post(
            "/sessions", {"room": room, "commitment": hashlib.sha256(SEED).hexdigest()}
        )
        shown = {"authorization": f"Bearer {made['token']}"}
        self.post(f"/sessions/{made['session']}/opening", {"seed": SEED.hex()}, headers=shown)
        given = {name: made[name] for name in ("statement", "signature")}
        return Session(made["session"], room, shown, given)

    def drop(self, session: Session) -> dict[str, Any]:
        """A staked drop that has landed; returns its receipt."""
        body = {"session": session.id, "stake": 100}
        path = f"/rooms/{session.room}/drops?wait=1"
        receipt: dict[str, Any] = self.post(path, body, headers=session.shown)["receipt"]
        return receipt

    def end(self, session: Session) -> dict[str, Any]:
        return self.post(f"/sessions/{session.id}/end", headers=session.shown)

    def export(self, session: Session, *heard: dict[str, Any]) -> dict[str, Any]:
        reply = self.http.get(f"/sessions/{session.id}/export", headers=session.shown)
        assert reply.is_success, reply.text
        return {**reply.json(), "heard": list(heard), "heard_session": session.statement}

    def log(self) -> dict[str, Any]:
        found: dict[str, Any] = self.http.get("/log").json()
        return found


@dataclass
class House:
    """A ledger, the data directory of its server, and a backup as the operator's page makes it."""

    url: str
    folder: Path

    @property
    def file(self) -> Path | None:
        return self.folder / "plinko.db" if self.url.startswith("sqlite") else None

    @property
    def key(self) -> Path:
        return self.folder / f"{'secret' if self.file is None else 'plinko.db-secret'}-signing-key"

    @property
    def options(self) -> list[str]:
        return ["--database-url", self.url, "--data", str(self.folder)]

    @contextlib.contextmanager
    def open(self) -> Iterator[Visit]:
        with (
            serving(database_url=self.url, data=str(self.folder)) as server,
            server.client("/api/v1") as http,
        ):
            yield Visit(http, server)

    def refusal(self) -> str:
        """Why a start is refused."""
        settings = Settings(database_url=self.url, data=str(self.folder), port=0)
        with pytest.raises(SettingError) as refused:
            open_ledger(create_app(settings).state.services)
        return str(refused.value)

    def printed_refusal(self) -> str:
        """What a start prints that is refused."""
        command = [sys.executable, "-m", "plinko", "serve", "--port", "0", *self.options]
        finished = run(*command)
        assert finished.returncode == 2, finished.stderr
        assert len(finished.stderr.strip().splitlines()) == 1
        return finished.stderr

    def ledger(self, *command: str) -> int:
        return main(["ledger", *command, *self.options])

    def back_up(self) -> None:
        if self.file is not None:
            assert self.ledger("backup", str(self.folder / "backup.db")) == 0
        else:
            done("pg_dump", "--file", str(self.folder / "backup.sql"), self.url)

    def restore(self) -> None:
        """Put the backup in place of the ledger."""
        if self.file is not None:
            for end in ("", "-wal", "-shm"):
                Path(f"{self.file}{end}").unlink(missing_ok=True)
            shutil.copy(self.folder / "backup.db", self.file)
            return
        empty = "DROP SCHEMA public CASCADE; CREATE SCHEMA public"
        done("psql", "--quiet", "--command", empty, self.url)
        options = ("--quiet", "--single-transaction", "--set", "ON_ERROR_STOP=1", "--file")
        done("psql", *options, str(self.folder / "backup.sql"), self.url)


def house_at(url: str, folder: Path) -> House:
    if not url.startswith("sqlite") and not shutil.which("pg_dump"):
        pytest.skip("PostgreSQL's client programs are not here")
    return House(url, folder)


@pytest.fixture
def house(url: str, tmp_path: Path) -> House:
    return house_at(url, tmp_path)


def checked(export: dict[str, Any], key: str | None = None) -> Verdict:
    return check_session(read_export(export), kernel_digest=KERNEL, key=key)


def failures(export: dict[str, Any], key: str | None = None) -> set[str]:
    return {step.name for step in checked(export, key).failed}


def independently(export: dict[str, Any], key: str | None = None) -> list[str]:
    """What does not hold by the checker that was written from the documents."""
    program = runpy.run_path(str(VERIFIER))
    return [*program["failures"](export, key), *program["path_failures"](export)]


@dataclass
class Story:
    """A session that was over at the backup, and two that were open. Since then one took drops, and
    the server revealed the secret of the other.
    """

    house: House
    room: str
    owner: dict[str, str]
    over: Session
    open_one: Session
    told: Session
    early: list[dict[str, Any]]
    lost: list[dict[str, Any]]
    secret: str
    exported: dict[str, Any]
    printed: str
    before: dict[str, Any]


@pytest.fixture(scope="module", params=[SQLITE, POSTGRESQL])
def story(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Story:
    folder = tmp_path_factory.mktemp("story")
    house = house_at(new_database(request, folder), folder)
    with house.open() as visit:
        room, owner = visit.room()
        over, open_one, told = (visit.session(room) for _ in range(3))
        early = [visit.drop(each) for each in (over, open_one, open_one, told)]
        visit.end(over)
        house.back_up()
        lost = [visit.drop(open_one) for _ in range(3)]
        visit.post(f"/rooms/{room}/drops?wait=1", headers=KEYED)
        secret = visit.end(told)["server_seed"]
        before = visit.log()
        exported = visit.export(over, early[0])
    house.restore()
    assert "`plinko ledger restore`" in house.printed_refusal()
    assert "`plinko ledger restore`" in house.refusal()
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert house.ledger("restore") == 0
    return Story(
        house, room, owner, over, open_one, told, early, lost, secret, exported,
        printed.getvalue(), before,
    )  # fmt: skip


def test_a_restored_backup_gives_no_player_what_another_time_has_shown(story: Story) -> None:
    room = story.room
    with story.house.open() as visit:
        for each in (story.open_one, story.told):
            body = {"session": each.id, "stake": 100}
            refused = visit.http.post(f"/rooms/{room}/drops", json=body, headers=each.shown)
            assert (refused.status_code, refused.json()["code"]) == (409, "session-state")
            assert "restored a backup" in refused.json()["detail"]
            state = visit.http.get(f"/sessions/{each.id}").json()
            assert (state["ended"], state["void"]) == (True, True)
        assert visit.end(story.told)["server_seed"] == story.secret
        # The key of a request in the lost time is closed, and the owner's token is valid.
        made = visit.post(f"/rooms/{room}/drops?wait=1", headers=KEYED)
        assert visit.post(f"/rooms/{room}/drops?wait=1", headers=KEYED)["ball"] == made["ball"]
        assert visit.http.post(f"/rooms/{room}/reset", headers=story.owner).is_success


def test_the_log_goes_on_with_a_signed_statement_and_all_receipts_are_proven(story: Story) -> None:
    with story.house.open() as visit:
        known = visit.log()
        (signed,) = known["restores"]
        said = signed["statement"]
        assert is_signed(said, bytes.fromhex(signed["signature"]), bytes.fromhex(known["key"]))
        assert (said["former"], said["size"], said["sessions"]) == (None, 4, 2)
        assert said["log"] in story.printed
        assert "2 open ones ended" in story.printed
        head = known["head"]["statement"]
        assert (head["size"], head["log"]) == (0, said["log"])
        assert (story.before["head"]["statement"]["size"], story.before["key"]) == (7, known["key"])
        # What each player has received is proven, with the lost drops as void ones.
        early = story.early
        first = visit.export(story.over, early[0])
        void = visit.export(story.open_one, *early[1:3], *story.lost)
        for export in (story.exported, first, void, visit.export(story.told, early[3])):
            assert failures(export, known["key"]) == set()
            assert independently(export, known["key"]) == []
        assert len(void["drops"]) == 2
        assert "void" in {step.name for step in checked(void).steps}
        forged = json.loads(json.dumps(void))
        forged["heard"][-1]["receipt"]["seed"] = "1"
        assert failures(forged) == {"heard"}
        # A new session is in the new log.
        again = visit.session(story.room)
        receipt = visit.drop(again)
        visit.end(again)
        export = visit.export(again, receipt)
        assert receipt["index"] == 0
        assert export["head"]["statement"]["log"] == said["log"]
        assert failures(export, known["key"]) == set()
        assert independently(export) == []
        stale = json.loads(json.dumps(export))
        del stale["head"]["statement"]["log"]
        assert {"head", "receipt"} <= failures(stale), "no receipt passes from log to log"
    with story.house.open() as visit:
        assert visit.log()["head"]["statement"]["size"] == 1


def test_after_a_disaster_play_goes_on_from_the_backup_of_a_running_server(
    house: House, tmp_path_factory: pytest.TempPathFactory, capsys: pytest.CaptureFixture[str]
) -> None:
    safe = tmp_path_factory.mktemp("safe")
    copy, secrets = safe / "plinko.db", safe / "secrets.tar"
    with house.open() as visit:
        room, owner = visit.room()
        session = visit.session(room)
        heard = visit.drop(session)
        visit.end(session)
        export = visit.export(session, heard)
        code = house.ledger("backup", str(copy), "--secrets", str(secrets))
        if house.file is None:
            assert code == 2
            assert f"pg_dump --format=custom --file={copy}" in capsys.readouterr().err
            done("pg_dump", "--format=custom", f"--file={copy}", house.url)
        visit.drop(visit.session(room))
    assert secrets.stat().st_mode & 0o077 == 0
    assert house.file is None or copy.stat().st_mode & 0o077 == 0
    for each in house.folder.iterdir():  # the disk is lost
        each.unlink()
    if house.file is None:
        empty = "DROP SCHEMA public CASCADE; CREATE SCHEMA public"
        done("psql", "--quiet", "--command", empty, house.url)
        done("pg_restore", "--no-owner", "--dbname", house.url, str(copy))
    else:
        shutil.copy(copy, house.file)
    done("tar", "--extract", "--file", str(secrets), "--directory", str(house.folder))
    assert house.ledger("restore") == 0
    with house.open() as visit:
        visit.http.post(f"/rooms/{room}/reset", headers=owner).raise_for_status()
        again = visit.session(room)
        more = [visit.drop(again), visit.drop(again)]
        visit.end(again)
        assert failures(visit.export(again, *more)) == set()
        assert [each["receipt"] for each in visit.export(session)["drops"]] == [
            each["receipt"] for each in export["drops"]
        ]
    assert house.ledger("check") == 0


@on_sqlite
def test_a_backup_overwrites_nothing_and_says_which_secrets_it_lacks(
    house: House, capsys: pytest.CaptureFixture[str]
) -> None:
    with house.open() as visit:
        visit.room()
    copy = house.folder / "copy.db"
    assert house.ledger("backup", str(copy)) == 0
    printed = capsys.readouterr().out
    assert "left out: plinko.db-secret, plinko.db-secret-signing-key" in printed
    before = copy.read_bytes()
    assert house.ledger("backup", str(copy)) == 2
    assert "exists: name a new file" in capsys.readouterr().err
    assert copy.read_bytes() == before
    assert main(["ledger", "check", "--database-url", f"sqlite:///{copy}"]) == 0
    gone = ["--database-url", f"sqlite:///{house.folder / 'none.db'}"]
    assert main(["ledger", "backup", str(house.folder / "x.db"), *gone]) == 2
    assert not (house.folder / "x.db").exists()


@on_sqlite_first
async def test_a_restore_without_a_backup_continues_no_key_session_or_log(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        keyed = f"/rooms/{room}/drops?wait=1"
        assert [visit.post(keyed, headers=KEYED)["ball"] for _ in range(2)] == [0, 0]
        session = visit.session(room)
        for _ in range(3):
            visit.drop(session)
        former = visit.log()["head"]["statement"]["root"]
    assert house.ledger("restore") == 0, "also with the ledger that the server left"
    with house.open() as visit:
        assert [visit.post(keyed, headers=KEYED)["ball"] for _ in range(2)] == [4, 4]
        known = visit.log()
        (signed,) = known["restores"]
        assert signed["statement"]["root"] == former
        assert known["head"]["statement"]["root"] == merkle.root(0, lambda *_: b"").hex()
        assert visit.export(session)["head"]["statement"]["root"] == former
        token = session.shown["authorization"].removeprefix("Bearer ")
        async with playing(visit.server.socket(room)) as player:  # a page that joins again
            await player.send(type="session", session=session.id, token=token, ref="s")
            state = await player.until("session")
            assert (state["ended"], state["void"], state["drops"]) == (True, True, 3)


@on_sqlite_first
def test_a_restore_after_a_restore_names_the_log_that_was_lost(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        session = visit.session(room)
        visit.drop(session)
        house.back_up()
    logs: list[str | None] = [None]
    for _ in range(2):
        house.restore()
        assert house.ledger("restore") == 0
        with house.open() as visit:
            (signed,) = visit.log()["restores"]
            assert signed["statement"]["former"] is None
            assert signed["statement"]["superseded"] == logs[-1]
            logs.append(signed["statement"]["log"])
            other = visit.session(room)
            visit.drop(other)
            visit.end(other)
            assert failures(visit.export(other)) == set()
    assert len(set(logs)) == 3
    assert house.ledger("restore") == 0
    with house.open() as visit:
        first, second = (each["statement"] for each in visit.log()["restores"])
        assert (second["former"], second["size"]) == (first["log"], 1)
        for each in (session, other):
            assert failures(visit.export(each)) == set()


@on_sqlite_first
def test_a_server_restores_by_its_own_flag_only_what_it_would_refuse(house: House) -> None:
    settings = Settings(database_url=house.url, data=str(house.folder))
    with house.open() as visit:
        room, _ = visit.room()
        house.back_up()
        visit.session(room)
    restore_if_refused(settings)
    with house.open() as visit:
        assert visit.log()["restores"] == []
    house.restore()
    restore_if_refused(settings)
    with house.open() as visit:
        assert len(visit.log()["restores"]) == 1


@on_sqlite
def test_a_copy_is_checked_without_being_touched(
    house: House, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        visit.drop(visit.session(room))
        house.back_up()
    (tmp_path / "copy").mkdir()
    copy = House(f"sqlite:///{tmp_path / 'copy' / 'plinko.db'}", tmp_path / "copy")
    shutil.copy(tmp_path / "backup.db", tmp_path / "copy" / "plinko.db")
    for _ in range(2):
        assert copy.ledger("check") == 0
    assert "sound" in capsys.readouterr().out
    assert copy.ledger("prune", "--keep-days", "1") == 2
    assert "is missing: it was restored, copied or moved" in capsys.readouterr().err
    assert not (tmp_path / "copy" / "plinko.db-epoch").exists()


# Keys.


@on_sqlite_first
def test_a_lost_or_changed_key_refuses_the_start_until_it_is_back(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
    kept = house.key.read_bytes()
    house.key.unlink()
    with house.open() as visit:  # nothing was signed, so any key will do
        room, _ = visit.room()
        visit.session(room)
    assert house.key.read_bytes() != kept
    kept = house.key.read_bytes()
    house.key.unlink()
    assert f"{house.key} is missing" in house.refusal()
    assert not house.key.exists(), "no key is made in its place"
    assert house.ledger("restore") == 2
    house.key.write_text("ab" * 32 + "\n")
    assert f"{house.key} has another key" in house.refusal()
    house.key.write_bytes(kept)
    with house.open() as visit:
        visit.session(room)


def test_after_a_change_of_the_key_all_receipts_stay_proven(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        over, open_one = visit.session(room), visit.session(room)
        heard = [visit.drop(over), visit.drop(open_one)]
        visit.end(over)
        old = visit.log()["key"]
        taken_before = visit.export(over, heard[0])
    keys = [old]
    for _ in range(2):
        assert house.ledger("rotate-key") == 0
        with house.open() as visit:
            keys.append(visit.log()["key"])
    assert len(set(keys)) == 3
    with house.open() as visit:
        state = visit.http.get(f"/sessions/{open_one.id}").json()
        assert (state["ended"], state["void"], state["key"]) == (True, False, old)
        new = visit.session(room)
        late = visit.drop(new)
        visit.end(new)
        assert "keys" not in visit.export(new, late)
        exports = [visit.export(over, heard[0]), visit.export(open_one, heard[1])]
        for export in exports:
            assert export["key"] == keys[-1]
            assert [each["statement"]["former"] for each in export["keys"]] == keys[1::-1]
        for export in (taken_before, *exports, visit.export(new, late)):
            for key in {*keys} & {export["key"], *formers(export)}:
                assert failures(export, key) == set()
                assert independently(export, key) == []
            assert failures(export, "ab" * 32) == {"key"}
    for number, export in enumerate(forged_keys(exports[0])):
        assert failures(export, keys[-1]), f"forgery {number}"
        assert independently(export, keys[-1]), f"forgery {number}"


def formers(export: dict[str, Any]) -> list[str]:
    return [each["statement"]["former"] for each in export.get("keys", ())]


def forged_keys(export: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The export with a change of the key left out, exchanged, or unsigned."""
    changes: tuple[Callable[[Any], object], ...] = (
        lambda keys: keys.pop(0),
        lambda keys: keys.pop(1),
        lambda keys: keys.reverse(),
        lambda keys: keys[0].update(signature=keys[1]["signature"]),
        lambda keys: keys[0]["statement"].update(former="ab" * 32),
    )
    for change in changes:
        forged = json.loads(json.dumps(export))
        change(forged["keys"])
        yield forged


@on_sqlite_first
def test_a_key_that_is_lost_for_ever_is_replaced_in_the_open(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        session = visit.session(room)
        visit.drop(session)
        old = visit.log()["key"]
    house.key.unlink()
    assert house.ledger("rotate-key") == 2, "it is not known to be lost"
    assert house.ledger("rotate-key", "--lost") == 0
    with house.open() as visit:
        (change,) = visit.log()["keys"]
        assert (change["statement"]["former"], change["former_signature"]) == (old, None)
        export = visit.export(session)
        assert failures(export, export["key"]) == set()
        assert failures(export, old) == {"key"}, "only the new key says that it follows the old one"


@on_sqlite_first
def test_a_change_of_the_key_survives_its_end_at_any_step(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    class EndError(BaseException):
        pass

    def end(*values: object, **options: object) -> None:
        raise EndError

    with house.open() as visit:
        room, _ = visit.room()
        visit.session(room)
        keys = [visit.log()["key"]]
    for step, finished in (("_add", False), ("_File.prepare", False), ("_File.adopt", True)):
        with monkeypatch.context() as patch:
            patch.setattr(f"plinko.app.persistence.signing_key.{step}", end)
            with pytest.raises(EndError):
                house.ledger("rotate-key")
        if finished:
            assert "run `plinko ledger rotate-key` to finish it" in house.refusal()
            assert house.ledger("rotate-key") == 0
        with house.open() as visit:
            keys.append(visit.log()["key"])
            assert len(visit.log()["keys"]) == finished
    assert keys[0] == keys[1] == keys[2] != keys[3]


@on_sqlite_first
def test_a_lost_secret_of_tokens_is_told_at_the_start(
    house: House, caplog: pytest.LogCaptureFixture
) -> None:
    if house.file is None:
        secret = house.folder / "secret"
    else:
        secret = house.file.with_name("plinko.db-secret")
    with house.open() as visit:
        room, owner = visit.room()
        visit.session(room)
        kept = secret.read_bytes()
    assert "the secret of tokens" not in caplog.text
    secret.unlink()
    for _ in range(2):
        caplog.clear()
        with house.open() as visit:
            assert visit.http.post(f"/rooms/{room}/reset", headers=owner).status_code == 403
        assert "the owners of 1 open rooms and the players of 1 open sessions" in caplog.text
        assert str(secret) in caplog.text
    secret.write_bytes(kept)
    caplog.clear()
    with house.open() as visit:
        assert visit.http.post(f"/rooms/{room}/reset", headers=owner).is_success
    assert "the secret of tokens" not in caplog.text
