"""An honest session is proven; for each forgery the failed checks are named."""

import contextlib
import copy
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from plinko.app.cli import main
from plinko.app.fairness.check import Verdict, check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.fairness.signing import Signer
from plinko.app.protocol.messages import SignedReceipt
from plinko.app.settings import page_kernels
from plinko.engine.errors import RecordError
from tools.fairness.sessions import FORMER, KERNEL, SIGNER, draw, honest, restored
from tools.golden import session as golden

Forge = Callable[[dict[str, Any]], None]

HONEST = honest()


def checked(session: dict[str, Any], **known: Any) -> Verdict:
    return check_session(read_export(session), **{"kernel_digest": KERNEL, **known})


def test_an_honest_session_is_proven() -> None:
    verdict = checked(HONEST, key=SIGNER.public.hex())
    assert verdict.failed == []
    assert [step.name for step in verdict.steps if step.drop == 3] == [
        "receipt-session", "receipt-board", "receipt", "inclusion", "consistency", "start",
        "trajectory", "outcome", "payout",
    ]  # fmt: skip


def other_server_seed(session: dict[str, Any]) -> None:
    session["server_seed"] = "ff" * 32


def late_server_seed(session: dict[str, Any]) -> None:
    """The server draws its seed after the player's, and signs a new consistent session."""
    given = session["heard_session"]
    session.update({**honest(server_seed=b"\x55" * 32), "heard_session": given})


def statement_of_another(session: dict[str, Any]) -> None:
    """The player shows a statement that the server never signed."""
    session["heard_session"]["signature"] = "0" * 128


def other_client_seed(session: dict[str, Any]) -> None:
    session["client_seed"] = "ff" * 32


def skipped_drop(session: dict[str, Any]) -> None:
    del session["drops"][1]


def truncated_log(session: dict[str, Any]) -> None:
    del session["drops"][-1]


def denied_end(session: dict[str, Any]) -> None:
    """The server drops the last entry from the log and the session; the player has its receipt."""
    last = session["drops"][-1]
    heard = {name: last[name] for name in ("receipt", "index", "root", "signature")}
    session.update({**honest(3), "heard": [heard]})


def changed_payout(session: dict[str, Any]) -> None:
    session["drops"][2]["result"]["payout"] += 1


def withheld_result(session: dict[str, Any]) -> None:
    session["drops"][2]["result"] = None


def other_path(session: dict[str, Any]) -> None:
    session["drops"][0]["result"]["digest"] = "0" * 64


def other_bin(session: dict[str, Any]) -> None:
    session["drops"][0]["result"]["bin"] += 1


def changed_stake(session: dict[str, Any]) -> None:
    session["drops"][0]["receipt"]["stake"] = 1


def changed_table(session: dict[str, Any]) -> None:
    session["board"]["bins"]["multipliers"][0] += 1


def chosen_start(session: dict[str, Any]) -> None:
    """The server chooses a seed, and signs its receipt."""
    drop = session["drops"][1]
    drop["receipt"]["seed"] = "3173"
    entry = {"kind": "plinko log entry", "version": 1, "receipt": drop["receipt"],
             "index": drop["index"], "root": drop["root"]}  # fmt: skip
    drop["signature"] = SIGNER.sign(entry).hex()


def bad_signature(session: dict[str, Any]) -> None:
    session["session"]["signature"] = "0" * 128


def other_key(session: dict[str, Any]) -> None:
    session["key"] = Signer(b"\x08" * 32).public.hex()


def other_root(session: dict[str, Any]) -> None:
    session["drops"][2]["root"] = session["drops"][1]["root"]


def unrevealed(session: dict[str, Any]) -> None:
    session["server_seed"] = None


def unended(session: dict[str, Any]) -> None:
    session["end"] = None


def foreign_receipt(session: dict[str, Any]) -> None:
    session["drops"][0]["receipt"]["session"] = "another"


FORGERIES: list[tuple[Forge, set[str]]] = [
    (other_server_seed, {"server-seed", "end-seed", "start"}),
    (late_server_seed, {"heard-session"}),
    (statement_of_another, {"heard-session"}),
    (other_client_seed, {"client-seed", "start"}),
    (skipped_drop, {"counter", "truncated"}),
    (truncated_log, {"truncated"}),
    (denied_end, {"heard"}),
    (changed_payout, {"payout"}),
    (withheld_result, {"result"}),
    (other_path, {"trajectory"}),
    (other_bin, {"outcome"}),
    (changed_stake, {"receipt", "inclusion", "payout"}),
    (changed_table, {"board", "payouts", "start", "trajectory"}),
    (chosen_start, {"inclusion", "start", "trajectory", "outcome"}),
    (bad_signature, {"session"}),
    (other_key, {"session", "heard-session", "head", "end", "receipt"}),
    (other_root, {"receipt", "consistency"}),
    (unrevealed, {"server-seed-open", "end-seed"}),
    (unended, {"end"}),
    (foreign_receipt, {"receipt-session", "receipt", "inclusion"}),
]


@pytest.mark.parametrize(
    ("forge", "names"), FORGERIES, ids=lambda each: getattr(each, "__name__", "")
)
def test_each_forgery_is_named(forge: Forge, names: set[str]) -> None:
    session = copy.deepcopy(HONEST)
    forge(session)
    found = {step.name for step in checked(session).failed}
    # A changed payout table or path may fail the checks of payout and outcome, too.
    assert names <= found <= names | {"payout", "outcome"}


DRAWN = honest(2, drawing=draw())


def test_a_session_of_a_draw_is_proven() -> None:
    verdict = checked(DRAWN)
    assert verdict.failed == []
    assert [step.name for step in verdict.steps if step.drop == 1] == [
        "receipt-session", "receipt-board", "receipt", "inclusion", "consistency", "start",
        "drawn-bin", "trajectory", "outcome", "payout",
    ]  # fmt: skip
    assert "draw" in {step.name for step in verdict.steps}


def test_without_a_draw_a_statement_does_not_mention_one() -> None:
    assert "draw_digest" not in HONEST["session"]["statement"]
    assert "draw" not in HONEST


def lighter(session: dict[str, Any]) -> None:
    session["draw"]["weights"][0] -= 1


def other_list(session: dict[str, Any]) -> None:
    """Add a seed to a bin's list whose ball lands in that bin, but was not in the draw."""
    session["draw"]["seeds"][0].append(session["draw"]["seeds"][0][0])


def no_draw(session: dict[str, Any]) -> None:
    del session["draw"]


def steered(session: dict[str, Any]) -> None:
    """The server signs a receipt with a seed from another bin's list."""
    draw, receipt = session["draw"], session["drops"][0]["receipt"]
    at = session["drops"][0]["result"]["bin"]
    receipt["seed"] = next(seeds[0] for b, seeds in enumerate(draw["seeds"]) if seeds and b != at)
    _sign_again(session["drops"][0])


def aimed(session: dict[str, Any]) -> None:
    session["drops"][0]["receipt"]["aim"] = 0.0
    _sign_again(session["drops"][0])


def _sign_again(drop: dict[str, Any]) -> None:
    entry = {"kind": "plinko log entry", "version": 1, "receipt": drop["receipt"],
             "index": drop["index"], "root": drop["root"]}  # fmt: skip
    drop["signature"] = SIGNER.sign(entry).hex()


DRAWN_FORGERIES: list[tuple[Forge, set[str]]] = [
    (lighter, {"draw"}),
    (other_list, {"draw"}),
    (no_draw, {"draw", "start"}),
    (steered, {"inclusion", "start", "drawn-bin", "trajectory", "outcome"}),
    (aimed, {"inclusion", "start"}),
    (other_server_seed, {"server-seed", "end-seed", "start"}),
]


@pytest.mark.parametrize(
    ("forge", "names"), DRAWN_FORGERIES, ids=lambda each: getattr(each, "__name__", "")
)
def test_each_forgery_of_a_draw_is_named(forge: Forge, names: set[str]) -> None:
    session = copy.deepcopy(DRAWN)
    forge(session)
    found = {step.name for step in checked(session).failed}
    # Other secrets draw other bins, and an aim changes the path: more checks may fail.
    moved = {"start", "drawn-bin", "trajectory", "outcome", "payout"}
    assert names <= found <= names | moved


def _leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if not isinstance(value, dict | list):
        yield path
        return
    for key in value if isinstance(value, dict) else range(len(value)):
        yield from _leaves(value[key], (*path, key))


def _changed(value: Any) -> Any:
    if isinstance(value, str):
        return value[:-1] + ("1" if value[-1:] == "0" else "0")
    return 1 if value is None else value + 1


def test_any_change_in_a_draw_s_session_breaks_its_proof() -> None:
    """Each value of draw, signed statements, receipts, proofs and results is changed in turn."""
    parts = ("version", "key", "session", "draw", "client_seed", "server_seed", "drops",
             "head", "end", "heard_session")  # fmt: skip
    for path in _leaves({name: DRAWN[name] for name in parts}):
        session = copy.deepcopy(DRAWN)
        place: Any = session
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = _changed(place[path[-1]])
        with contextlib.suppress(RecordError):  # the change made the record malformed
            assert not checked(session).ok, path


def test_an_earlier_export_with_the_rooms_tick_is_proven() -> None:
    """No signed value contains a drop's last tick, so the check ignores it."""
    session = copy.deepcopy(HONEST)
    session["drops"][0]["result"]["tick"] = 60
    assert checked(session).ok


def test_another_kernel_and_another_server_are_named() -> None:
    assert [step.name for step in checked(HONEST, kernel_digest="0" * 64).failed] == ["kernel"]
    assert [step.name for step in checked(HONEST, key="0" * 64).failed] == ["key"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 2}, "version is 2, not 1"),
        ({"extra": 1}, "unknown field `extra`"),
        ({"key": "xyz"}, "key 'xyz' is not 64 hexadecimal digits"),
        ({"server_seed": "00"}, "server-seed '00' is not 64 hexadecimal digits"),
        ({"board": {"width": -1}}, "board: width"),
    ],
)
def test_an_invalid_session_is_named(change: dict[str, Any], message: str) -> None:
    with pytest.raises(RecordError, match=message):
        checked({**HONEST, **change})


def test_a_field_that_is_signed_but_unknown_is_refused() -> None:
    session = copy.deepcopy(HONEST)
    session["drops"][0]["receipt"]["bonus"] = 1
    with pytest.raises(RecordError, match="plinko receipt"):
        checked(session)


NUMBERS: list[tuple[str | int, ...]] = [
    ("drops", 0, "receipt", "drop"),
    ("drops", 0, "receipt", "stake"),
    ("drops", 0, "receipt", "ball"),
    ("drops", 0, "receipt", "time"),
    ("drops", 0, "index"),
    ("drops", 0, "result", "payout"),
    ("drops", 0, "result", "bin"),
    ("head", "statement", "size"),
    ("end", "statement", "drops"),
    ("heard", 0, "receipt", "drop"),
    ("heard", 0, "index"),
]


@pytest.mark.parametrize("number", [-1, 2**53, 2**70], ids=["negative", "large", "huge"])
@pytest.mark.parametrize("path", NUMBERS, ids=lambda path: ".".join(map(str, path)))
def test_a_number_that_cannot_be_is_named_by_the_command_line(
    path: tuple[str | int, ...],
    number: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    session = copy.deepcopy(HONEST)
    last = session["drops"][-1]
    session["heard"] = [{name: last[name] for name in ("receipt", "index", "root", "signature")}]
    session = copy.deepcopy(session)
    place: Any = session
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = number
    file = tmp_path / "session.json"
    file.write_text(json.dumps(session))
    assert main(["verify", str(file)]) == 2
    assert str(path[-1]) in capsys.readouterr().err


def test_a_stake_that_could_pay_more_than_readers_keep_is_refused() -> None:
    session = copy.deepcopy(HONEST)
    session["board"]["bins"]["multipliers"][0] = 1e9
    session["drops"][0]["receipt"]["stake"] = 10**9
    with pytest.raises(RecordError, match=r"stake 1000000000 could pay more than 9007199254740991"):
        checked(session)


@pytest.mark.parametrize("part", ["", "board", "drops[0].result", "session.statement"])
def test_a_member_given_twice_is_refused_and_named(
    part: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = copy.deepcopy(HONEST)
    place: Any = session
    for step in (step for step in re.split(r"[.\[\]]+", part) if step):
        place = place[int(step) if step.isdigit() else step]
    place.update(again=1, more=1)
    file = tmp_path / "session.json"
    file.write_text(json.dumps(session).replace('"more":', '"again":'))
    assert main(["verify", str(file)]) == 2
    where = f"{part}." if part else ""
    assert f"{where}again: the key is given twice" in capsys.readouterr().err


def test_the_command_line_proves_and_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = honest(1, kernel=kernel_digest_of(page_kernels().read_bytes()))
    file = tmp_path / "session.json"
    file.write_text(json.dumps(session))
    assert main(["verify", str(file)]) == 0
    told = capsys.readouterr().out
    assert "proven: 1 drop," in told
    assert "proven: the server had committed before" in told
    file.write_text(json.dumps({**session, "heard_session": None}))
    assert main(["verify", str(file)]) == 0
    told = capsys.readouterr().out
    assert "not proven: that the server committed before it knew the player's secret" in told
    assert "neither side could choose" not in told
    changed_payout_of_first = copy.deepcopy(session)
    changed_payout_of_first["drops"][0]["result"]["payout"] += 1
    file.write_text(json.dumps(changed_payout_of_first))
    assert main(["verify", str(file)]) == 1
    assert "not proven: payout of drop 0" in capsys.readouterr().out
    file.write_text(json.dumps(session))
    assert main(["verify", str(file), "--key", "0" * 64]) == 1
    assert "not proven: key" in capsys.readouterr().out


def test_the_golden_session_is_this_one() -> None:
    """tests/js/fairness reads these files; `python -m tools.golden.session` rewrites them."""
    assert golden.FILE.read_text() == golden.text()
    assert golden.DRAWN_FILE.read_text() == golden.drawn_text()
    assert golden.RESTORED_FILE.read_text() == golden.restored_text()


def test_a_void_session_of_a_former_key_is_proven() -> None:
    export = restored()
    for key in (SIGNER, FORMER):
        assert checked(export, key=key.public.hex()).failed == []
    names = [step.name for step in checked(export).steps]
    assert (names.count("keys"), names.count("void"), names.count("heard")) == (1, 1, 4)


@pytest.mark.parametrize(("forge", "expected"), [
    (lambda s: s.pop("keys"), {"session", "heard-session", "end", "receipt", "heard"}),
    (lambda s: s["keys"][0].update(signature="0" * 128), {"keys"}),
    (lambda s: s["keys"][0]["statement"].update(key="ab" * 32), {"keys"}),
    (lambda s: s["keys"].reverse() or s["keys"].append(s["keys"][0]), {"keys"}),
    (lambda s: s["heard"][3]["receipt"].update(seed="1"), {"heard"}),
    (lambda s: s["heard"][3].update(signature="0" * 128), {"heard"}),
    (lambda s: s["end"]["statement"].pop("void"), {"end", "heard"}),
    (lambda s: s["end"]["statement"].update(void="c3" * 16), {"end"}),
    (lambda s: s["head"]["statement"].pop("log"), {"head", "receipt", "heard"}),
    (lambda s: s["drops"].pop(), {"truncated"}),
])  # fmt: skip
def test_what_is_forged_in_a_void_session_is_found(forge: Forge, expected: set[str]) -> None:
    export = restored()
    forge(export)
    assert {step.name for step in checked(export).failed} == expected


def test_only_a_key_that_handed_on_its_place_is_known_by_its_successor() -> None:
    export = restored()
    export["keys"][0]["former_signature"] = None
    assert checked(export, key=SIGNER.public.hex()).failed == []
    assert [step.name for step in checked(export, key=FORMER.public.hex()).failed] == ["key"]
    export["keys"][0]["former_signature"] = "0" * 128
    assert [step.name for step in checked(export, key=FORMER.public.hex()).failed] == ["key"]


def test_a_player_over_rest_names_the_replies_that_they_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = honest(1, kernel=kernel_digest_of(page_kernels().read_bytes()))
    begun = {**session.pop("heard_session"), "session": "s1", "token": "t", "open": False}
    file, opened, dropped = (tmp_path / f"{name}.json" for name in ("session", "begun", "drop"))
    file.write_text(json.dumps(session))
    opened.write_text(json.dumps(begun))
    receipt = {name: session["drops"][0][name] for name in SignedReceipt.__struct_fields__}
    dropped.write_text(json.dumps({"room": "main", "ball": 0, "receipt": receipt}))
    heard = ("--heard", str(opened), "--heard", str(dropped))
    assert main(["verify", str(file), *heard]) == 0
    assert "proven: the server had committed before" in capsys.readouterr().out
    # The check names a server that drew its secret late, or gave the player another receipt.
    late = copy.deepcopy(begun)
    late["statement"]["server_commitment"] = "5" * 64
    opened.write_text(json.dumps(late))
    assert main(["verify", str(file), *heard]) == 1
    assert "not proven: heard-session" in capsys.readouterr().out
    opened.write_text(json.dumps(begun))
    other = {**receipt, "receipt": {**receipt["receipt"], "stake": 7}}
    dropped.write_text(json.dumps({"receipt": other}))
    assert main(["verify", str(file), *heard]) == 1
    assert "not proven:" in capsys.readouterr().out
    dropped.write_text("{}")
    assert main(["verify", str(file), *heard]) == 2
    assert "the kept reply has neither" in capsys.readouterr().err
