"""An honest session is proven; for each forgery the failed checks are named."""

import contextlib
import copy
import json
import re
from collections.abc import Callable, Iterator, Sequence
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

Forge = Callable[[dict[str, Any]], object]

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


def late_server_seed(session: dict[str, Any]) -> None:
    """The server draws its seed after the player's, and signs a new consistent session."""
    given = session["heard_session"]
    session.update({**honest(server_seed=b"\x55" * 32), "heard_session": given})


def denied_end(session: dict[str, Any]) -> None:
    """The server drops the last entry from the log and the session; the player has its receipt."""
    session.update({**honest(3), "heard": [kept_reply(session)]})


def kept_reply(session: dict[str, Any]) -> dict[str, Any]:
    """What the player of a session was sent with the last drop."""
    return {name: session["drops"][-1][name] for name in SignedReceipt.__struct_fields__}


def chosen_start(session: dict[str, Any]) -> None:
    """The server chooses a seed, and signs its receipt."""
    session["drops"][1]["receipt"]["seed"] = "3173"
    _sign_again(session["drops"][1])


def _sign_again(drop: dict[str, Any]) -> None:
    entry = {"kind": "plinko log entry", "version": 1, "receipt": drop["receipt"],
             "index": drop["index"], "root": drop["root"]}  # fmt: skip
    drop["signature"] = SIGNER.sign(entry).hex()


def at(value: Any, path: Sequence[str | int]) -> Any:
    for step in path:
        value = value[step]
    return value


def change(path: str, value: Any) -> Forge:
    """Replaces the value at a path such as `drops.0.stake`; a function computes it."""
    *places, last = (int(step) if step.isdigit() else step for step in path.split("."))

    def forge(session: dict[str, Any]) -> None:
        place = at(session, places)
        place[last] = value(place[last]) if callable(value) else value

    return forge


def one_more(value: Any) -> Any:
    return value + 1


OTHER_SERVER_SEED = change("server_seed", "ff" * 32)
FORGERIES: dict[str, tuple[Forge, set[str]]] = {
    "another server seed": (OTHER_SERVER_SEED, {"server-seed", "end-seed", "start"}),
    "a late server seed": (late_server_seed, {"heard-session"}),
    "a statement that the server never signed": (
        change("heard_session.signature", "0" * 128),
        {"heard-session"},
    ),
    "another client seed": (change("client_seed", "ff" * 32), {"client-seed", "start"}),
    "a skipped drop": (lambda session: session["drops"].pop(1), {"counter", "truncated"}),
    "a truncated log": (lambda session: session["drops"].pop(), {"truncated"}),
    "a denied end": (denied_end, {"heard"}),
    "a changed payout": (change("drops.2.result.payout", one_more), {"payout"}),
    "a withheld result": (change("drops.2.result", None), {"result"}),
    "another path": (change("drops.0.result.digest", "0" * 64), {"trajectory"}),
    "another bin": (change("drops.0.result.bin", one_more), {"outcome"}),
    "a changed stake": (change("drops.0.receipt.stake", 1), {"receipt", "inclusion", "payout"}),
    "a changed table": (
        change("board.bins.multipliers.0", one_more),
        {"board", "payouts", "start", "trajectory"},
    ),
    "a chosen start": (chosen_start, {"inclusion", "start", "trajectory", "outcome"}),
    "a bad signature": (change("session.signature", "0" * 128), {"session"}),
    "another key": (
        change("key", Signer(b"\x08" * 32).public.hex()),
        {"session", "heard-session", "head", "end", "receipt"},
    ),
    "another root": (
        lambda session: session["drops"][2].update(root=session["drops"][1]["root"]),
        {"receipt", "consistency"},
    ),
    "an unrevealed seed": (change("server_seed", None), {"server-seed-open", "end-seed"}),
    "no end": (change("end", None), {"end"}),
    "a foreign receipt": (
        change("drops.0.receipt.session", "another"),
        {"receipt-session", "receipt", "inclusion"},
    ),
}


@pytest.mark.parametrize(("forge", "names"), FORGERIES.values(), ids=FORGERIES)
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
    # Without a draw a statement does not mention one.
    assert "draw_digest" not in HONEST["session"]["statement"]
    assert "draw" not in HONEST


def other_list(session: dict[str, Any]) -> None:
    """Add a seed to a bin's list whose ball lands in that bin, but was not in the draw."""
    session["draw"]["seeds"][0].append(session["draw"]["seeds"][0][0])


def steered(session: dict[str, Any]) -> None:
    """The server signs a receipt with a seed from another bin's list."""
    draw, receipt = session["draw"], session["drops"][0]["receipt"]
    bin_ = session["drops"][0]["result"]["bin"]
    receipt["seed"] = next(seeds[0] for b, seeds in enumerate(draw["seeds"]) if seeds and b != bin_)
    _sign_again(session["drops"][0])


def aimed(session: dict[str, Any]) -> None:
    session["drops"][0]["receipt"]["aim"] = 0.0
    _sign_again(session["drops"][0])


DRAWN_FORGERIES: dict[str, tuple[Forge, set[str]]] = {
    "a lighter bin": (change("draw.weights.0", lambda weight: weight - 1), {"draw"}),
    "another list": (other_list, {"draw"}),
    "no draw": (lambda session: session.pop("draw"), {"draw", "start"}),
    "steered": (steered, {"inclusion", "start", "drawn-bin", "trajectory", "outcome"}),
    "aimed": (aimed, {"inclusion", "start"}),
    "another server seed": (OTHER_SERVER_SEED, {"server-seed", "end-seed", "start"}),
}


@pytest.mark.parametrize(("forge", "names"), DRAWN_FORGERIES.values(), ids=DRAWN_FORGERIES)
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
        place = at(session, path[:-1])
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


NUMBERS = """
drops.0.receipt.drop drops.0.receipt.stake drops.0.receipt.ball drops.0.receipt.time drops.0.index
drops.0.result.payout drops.0.result.bin head.statement.size end.statement.drops
heard.0.receipt.drop heard.0.index
"""


@pytest.mark.parametrize("path", NUMBERS.split())
def test_a_number_that_cannot_be_is_named_by_the_command_line(
    path: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "session.json"
    for number in (-1, 2**53, 2**70):
        session = copy.deepcopy({**HONEST, "heard": [kept_reply(HONEST)]})
        change(path, number)(session)
        file.write_text(json.dumps(session))
        assert main(["verify", str(file)]) == 2
        assert path.rpartition(".")[2] in capsys.readouterr().err


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
    steps = [step for step in re.split(r"[.\[\]]+", part) if step]
    at(session, [int(step) if step.isdigit() else step for step in steps]).update(again=1, more=1)
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
    paid = copy.deepcopy(session)
    change("drops.0.result.payout", one_more)(paid)
    file.write_text(json.dumps(paid))
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
    receipt = kept_reply(session)
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
