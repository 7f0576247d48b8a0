"""Check a fair session offline: recompute everything in its export and verify all signatures.

Everything that a server could forge has a named step. docs/fairness.md lists the steps, and
static/js/fairness/check.js has the same ones for the page.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, TypeVar

import msgspec

from plinko.app.errors import InvalidValueError
from plinko.app.fairness.export import ExportedDrop, KeyChange, SessionExport, Signed
from plinko.app.fairness.seeds import commitment, draw_mac, drop_seed, parse_hex
from plinko.app.fairness.signing import is_signed
from plinko.app.fairness.statements import (
    VERSION,
    Closing,
    KeyStatement,
    LogEntry,
    Receipt,
    SessionStatement,
    TreeHead,
    payouts_digest,
)
from plinko.app.protocol.messages import SignedReceipt
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.stakes import check_payout, payout_of
from plinko.engine import PHYSICS_VERSION, Board, drop, merkle
from plinko.engine.errors import EngineError, ParameterError, RecordError, SeedError

Kind = TypeVar("Kind", SessionStatement, Receipt, TreeHead, Closing, KeyStatement)

HEARD: Final = "heard"
HEARD_SESSION: Final = "heard-session"


@dataclass(frozen=True, slots=True)
class Step:
    """The outcome of one check, of the whole session or of drop number `drop`.

    `said` is the value in the export, `found` the recomputed one; `text` is for people.
    """

    name: str
    ok: bool
    text: str
    said: object = None
    found: object = None
    drop: int | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """All steps in order, the number of drops, and the server's public key."""

    steps: tuple[Step, ...]
    drops: int
    key: str

    @property
    def ok(self) -> bool:
        """Whether no step failed."""
        return all(step.ok for step in self.steps)

    @property
    def failed(self) -> list[Step]:
        return [step for step in self.steps if not step.ok]


def check_session(export: SessionExport, *, kernel_digest: str, key: str | None = None) -> Verdict:
    """Check a session completely.

    kernel_digest: of the kernels that the caller trusts. key: the server's public key in
    hexadecimal, if the caller knows it from another source. Raises RecordError if the export is
    malformed.
    """
    try:
        steps = tuple(_Check(export, kernel_digest, key).steps())
    except (InvalidValueError, ParameterError, SeedError) as error:
        raise RecordError(str(error), field=error.field) from error
    return Verdict(steps, len(export.drops), export.key)


def _same(name: str, text: str, said: object, found: object, number: int | None = None) -> Step:
    return Step(name, said == found, text, said, found, number)


def _typed(values: Mapping[str, object], kind: type[Kind]) -> Kind:
    """Parse a statement; raises RecordError if it has another kind or other fields."""
    fields = {key: value for key, value in values.items() if key not in ("kind", "version")}
    try:
        found = msgspec.convert(fields, kind)
    except msgspec.ValidationError as error:
        raise RecordError(f"{kind.KIND}: {error}", field=kind.KIND) from error
    if found.to_dict() != values:
        raise RecordError(
            f"a {kind.KIND} must have this kind, version {VERSION}, and no other fields",
            field=kind.KIND,
        )
    return found


class _Check:
    """The steps of one session."""

    def __init__(self, export: SessionExport, kernel_digest: str, key: str | None) -> None:
        self._export = export
        self._kernel = kernel_digest
        self._expected_key = key
        self._keys = [parse_hex(export.key, "key")]
        changes = () if export.keys is msgspec.UNSET else export.keys
        self._changes = [(each, _typed(each.statement, KeyStatement)) for each in changes]
        self._keys += [parse_hex(each.former, "keys") for _, each in self._changes]
        self._session = _typed(export.session.statement, SessionStatement)
        self._head = _typed(export.head.statement, TreeHead)
        self._root = parse_hex(self._head.root, "head.root")
        self._board = self._read_board()
        draw = export.draw
        self._draw = None if draw is msgspec.UNSET else Draw.of_values(self._board, draw)
        self._receipts = [_typed(each.receipt, Receipt) for each in export.drops]

    def _read_board(self) -> Board:
        try:
            return Board.from_json(self._export.board)
        except (EngineError, TypeError) as error:
            raise RecordError(f"board: {error}", field="board") from error

    def steps(self) -> Iterator[Step]:
        """Run all steps: the session, its end, then each drop."""
        yield from self._signatures()
        if self._export.heard_session is not None:
            yield self._heard_session(self._export.heard_session)
        yield from self._secrets()
        yield from self._what_is_played()
        yield self._counter()
        yield from self._end()
        for each, receipt in zip(self._export.drops, self._receipts, strict=True):
            check_payout(receipt.stake, self._board.bins.multipliers)
            yield from self._logged(each, receipt)
            yield from self._played(each, receipt)
        for heard in self._export.heard:
            yield self._heard(heard)

    def _signatures(self) -> Iterator[Step]:
        if self._expected_key is not None:
            known = self._reached(self._expected_key)
            said = self._expected_key if known else self._export.key
            yield _same("key", "the server's key", said, self._expected_key)
        for number, (change, statement) in enumerate(self._changes):
            yield self._changed(number, change, statement)
        yield self._signed("session", "the session's statement is signed", self._export.session)
        yield self._signed("head", "the log's head is signed", self._export.head)

    def _changed(self, number: int, change: KeyChange, statement: KeyStatement) -> Step:
        """Check that the later key vouches for the earlier one."""
        key, signature = self._keys[number], parse_hex(change.signature, "signature", 64)
        ok = statement.key == key.hex() and is_signed(change.statement, signature, key)
        text = "the server's next key says that this was its key"
        return Step("keys", ok, text, statement.former, "valid" if ok else "invalid")

    def _reached(self, key: str) -> bool:
        """Whether the caller's key is the server's, or has signed its successors up to that."""
        at = self._export.key
        for change, statement in self._changes:
            given = change.former_signature
            if at == key or given is None:
                break
            former = parse_hex(statement.former, "keys")
            if not is_signed(change.statement, parse_hex(given, "signature", 64), former):
                break
            at = statement.former
        return at == key

    def _signed(self, name: str, text: str, signed: Signed, number: int | None = None) -> Step:
        signature = parse_hex(signed.signature, "signature", 64)
        ok = any(is_signed(signed.statement, signature, key) for key in self._keys)
        return Step(name, ok, text, signed.signature, "valid" if ok else "invalid", number)

    def _heard_session(self, heard: Signed) -> Step:
        """Only a statement from before the server knew the player's secret binds the server."""
        if not self._signed(HEARD_SESSION, "", heard).ok:
            text = "this server signed the statement"
            return Step(HEARD_SESSION, False, text, heard.signature, "invalid")
        text = "the statement is the one that the player had before they opened"
        found = self._export.session.statement
        return _same(HEARD_SESSION, text, heard.statement, found)

    def _secrets(self) -> Iterator[Step]:
        export, session = self._export, self._session
        for name, secret, committed in (
            ("client-seed", export.client_seed, session.client_commitment),
            ("server-seed", export.server_seed, session.server_commitment),
        ):
            if secret is None:
                yield Step(f"{name}-open", False, f"the {name} is not opened", None, "a secret")
                continue
            found = commitment(parse_hex(secret, name)).hex()
            yield _same(name, f"the {name} is the one committed to", committed, found)

    def _what_is_played(self) -> Iterator[Step]:
        said, board = self._session, self._board
        yield _same("board", "the board", said.board_digest, board.digest)
        found = payouts_digest(board)
        yield _same("payouts", "the board's multipliers", said.payouts_digest, found)
        yield _same("physics", "the laws of motion", said.physics_version, PHYSICS_VERSION)
        yield _same("kernel", "the compiled solver", said.kernel_digest, self._kernel)
        if said.draw_digest is not None or self._draw is not None:
            drawn = None if self._draw is None else self._draw.digest
            text = "the published odds, and the balls of each bin"
            yield _same("draw", text, said.draw_digest, drawn)

    def _counter(self) -> Step:
        said = [receipt.drop for receipt in self._receipts]
        gap = next((i for i, number in enumerate(said) if number != i), None)
        text = "drops are numbered from 0, none left out"
        if gap is None:
            return Step("counter", True, text, len(said), len(said))
        return Step("counter", False, text, said[gap], gap, gap)

    def _end(self) -> Iterator[Step]:
        export = self._export
        if export.end is None:
            yield Step("end", False, "the session's end is signed", None, "a signed end")
            return
        yield self._signed("end", "the session's end is signed", export.end)
        end = _typed(export.end.statement, Closing)
        yield _same("end-session", "the end is this session's", end.session, self._session.session)
        yield _same("end-seed", "the end's server seed", end.server_seed, export.server_seed)
        text = "the log has every drop up to the session's end"
        yield _same("truncated", text, end.drops, len(export.drops))
        if end.void is not None:
            text = "a restored backup ended the session: drops that the backup lacks are void"
            yield _same("void", text, end.void, end.void)

    def _logged(self, each: ExportedDrop, receipt: Receipt) -> Iterator[Step]:
        number = receipt.drop
        same = partial(_same, number=number)
        yield same("receipt-session", "the receipt is this session's", receipt.session,
                   self._session.session)  # fmt: skip
        yield same("receipt-board", "the receipt's board", receipt.board_digest,
                   self._session.board_digest)  # fmt: skip
        yield self._entry_signed("receipt", each, number)
        index, head = each.index, self._head
        ok = merkle.is_included(
            receipt.leaf(), index, head.size, _hashes(each.inclusion), self._root
        )
        yield Step("inclusion", ok, "the receipt is in the log", index, head.root, number)
        root = parse_hex(each.root, "root")
        ok = merkle.is_consistent(index + 1, head.size, root, self._root, _hashes(each.consistency))
        text = "the log only grew since this receipt"
        yield Step("consistency", ok, text, each.root, head.root, number)

    def _entry_signed(self, name: str, each: SignedReceipt, number: int | None) -> Step:
        entry = LogEntry(each.receipt, each.index, each.root, self._head.log).to_dict()
        text = "the receipt and its place in the log are signed"
        return self._signed(name, text, Signed(entry, each.signature), number)

    def _played(self, each: ExportedDrop, receipt: Receipt) -> Iterator[Step]:
        same = partial(_same, number=receipt.drop)
        found = drop(self._board, receipt.seed, aim=receipt.aim)
        yield from self._start(receipt, found.bin)
        payout = payout_of(receipt.stake, found.score)
        if each.result is None:
            owed = {"bin": found.bin, "payout": payout}
            yield same("result", "the drop has ended and was paid", None, owed)
            return
        said = each.result
        yield same("trajectory", "every bit of the path", said.digest, found.digest)
        yield same(
            "outcome",
            "where the ball ended",
            [said.bin, said.score, said.t, said.x_end, said.unsettled],
            [found.bin, found.score, found.duration, found.x_end, found.unsettled],
        )
        yield same("payout", "what was paid", said.payout, payout)

    def _drawn(self, number: int) -> tuple[int | None, str] | None:
        """The bin, in a draw, and the seed that both secrets give; None if one is not opened."""
        server, client = self._export.server_seed, self._export.client_seed
        if server is None or client is None:
            return None
        secrets = (parse_hex(server, "server-seed"), parse_hex(client, "client-seed"))
        known = (*secrets, number, bytes.fromhex(self._board.digest))
        if self._draw is None:
            return None, str(drop_seed(*known))
        drawn, seed = self._draw.pick(draw_mac(*known))
        return drawn, str(seed)

    def _start(self, receipt: Receipt, landed: int | None) -> Iterator[Step]:
        """Check that both secrets give the seed, or in a draw the bin and one of its seeds."""
        if (found := self._drawn(receipt.drop)) is None:
            return
        drawn, seed = found
        same = partial(_same, number=receipt.drop)
        if self._draw is None:
            yield same("start", "the start is drawn by both secrets", receipt.seed, seed)
            return
        text = "the bin was drawn by published odds, then a ball that falls there"
        yield same("start", text, [receipt.seed, receipt.aim], [seed, None])
        yield same("drawn-bin", "the ball falls into the bin that was drawn", landed, drawn)

    def _heard(self, heard: SignedReceipt) -> Step:
        """Check that a receipt that the player received is the one in the export."""
        receipt = _typed(heard.receipt, Receipt)
        number, text = receipt.drop, "what the player was given is in the export"
        ours = self._entry_signed(HEARD, heard, number).ok
        if not ours or receipt.session != self._session.session:
            text = "this server signed the receipt in this session"
            return Step(HEARD, False, text, heard.index, None, number)
        drops: Sequence[ExportedDrop] = self._export.drops
        if number >= len(drops) and (drawn := self._void_seed(receipt)) is not None:
            text = "the receipt is of a void drop: both secrets draw its start"
            return _same(HEARD, text, receipt.seed, drawn, number)
        there = drops[number] if number < len(drops) else None
        found = there and [there.receipt, there.index, there.root]
        return _same(HEARD, text, [heard.receipt, heard.index, heard.root], found, number)

    def _void_seed(self, receipt: Receipt) -> str | None:
        """The seed of a drop that a restore has lost; None if no restore ended the session."""
        end = self._export.end
        if end is None or _typed(end.statement, Closing).void is None:
            return None
        found = self._drawn(receipt.drop)
        return None if found is None else found[1]


def _hashes(values: Sequence[str]) -> list[bytes]:
    return [parse_hex(value, "proof") for value in values]


def kernel_digest_of(artifact: bytes) -> str:
    """SHA-256 of the compiled solver, as 64 hexadecimal digits."""
    return hashlib.sha256(artifact).hexdigest()
