"""An honest session's export, made in memory, which tests then forge."""

from typing import Any

import msgspec

from plinko.app.fairness.check import kernel_digest_of
from plinko.app.fairness.export import KIND, VERSION, DropResult, SessionExport, Signed, make_export
from plinko.app.fairness.seeds import commitment, draw_mac, drop_seed
from plinko.app.fairness.signing import Signer
from plinko.app.fairness.statements import (
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
from plinko.app.rooms.stakes import payout_of
from plinko.engine import PHYSICS_VERSION, Board, drop, find_draw, merkle

KERNEL = kernel_digest_of(b"kernels")
BOARD = Board.preset("triangle-9")
SERVER_SEED, CLIENT_SEED = bytes(range(32)), bytes(range(32, 64))
SIGNER, FORMER = Signer(b"\x07" * 32), Signer(b"\x06" * 32)
MOST = (1 << 53) - 1
ODDS = [MOST, 0, 1, 3, MOST, 0, MOST, 7, 0, MOST]
"""Weights of the bins of BOARD: zero, nearly zero, and the maximum."""


def draw() -> Draw:
    return Draw.of(BOARD, **find_draw(BOARD, ODDS, per_bin=3))


class Log:
    """A server's Merkle log in memory: the hashes of its complete subtrees."""

    def __init__(self) -> None:
        self.size = 0
        self.nodes: dict[merkle.Node, bytes] = {}

    def lookup(self, level: int, number: int) -> bytes:
        return self.nodes[level, number]

    def add(self, leaf: bytes) -> bytes:
        """Append a leaf; returns the new root."""
        self.nodes.update(merkle.added(self.size, leaf, self.lookup))
        self.size += 1
        return merkle.root(self.size, self.lookup)


def signed(statement: Any, signer: Signer = SIGNER) -> Signed:
    values = statement.to_dict()
    return Signed(values, signer.sign(values).hex())


def honest(
    drops: int = 4,
    *,
    kernel: str = KERNEL,
    others: int = 2,
    server_seed: bytes = SERVER_SEED,
    drawing: Draw | None = None,
    signer: Signer = SIGNER,
    log: str | None = None,
    void: str | None = None,
) -> dict[str, Any]:
    """A session's export as JSON, including the statement that the player received at its start.

    others: leaves of other players between two of this session; drawing: the room's draw; log: the
    id of its log; void: the id of the log that began as the session ended.
    """
    leaves, played = Log(), []
    for number in range(drops):
        for other in range(others):
            leaves.add(f"other {number} {other}".encode())
        known = (server_seed, CLIENT_SEED, number, bytes.fromhex(BOARD.digest))
        seed, aim = drop_seed(*known), BOARD.drop.x + 0.01 if number % 2 else None
        if drawing is not None:
            (_, seed), aim = drawing.pick(draw_mac(*known)), None
        receipt = Receipt(
            "s1", number, 100, aim, str(seed), BOARD.digest, "main", number, 1000 + number
        )
        root = leaves.add(receipt.leaf()).hex()
        entry = LogEntry(receipt.to_dict(), leaves.size - 1, root, log)
        logged = SignedReceipt(entry.receipt, entry.index, root, signed(entry, signer).signature)
        played.append((logged, ended(seed, aim)))
    leaves.add(b"somebody came later")
    session = SessionStatement(
        session="s1",
        room="main",
        board_digest=BOARD.digest,
        payouts_digest=payouts_digest(BOARD),
        physics_version=PHYSICS_VERSION,
        kernel_digest=kernel,
        server_commitment=commitment(server_seed).hex(),
        client_commitment=commitment(CLIENT_SEED).hex(),
        time=999,
        draw_digest=None if drawing is None else drawing.digest,
    )
    head = TreeHead(leaves.size, merkle.root(leaves.size, leaves.lookup).hex(), 2000, log)
    bare = SessionExport(
        kind=KIND,
        version=VERSION,
        key=signer.public.hex(),
        session=signed(session, signer),
        board=BOARD.to_dict(),
        client_seed=CLIENT_SEED.hex(),
        server_seed=server_seed.hex(),
        drops=[],
        head=signed(head, signer),
        end=signed(Closing("s1", drops, server_seed.hex(), 1999, void), signer),
        heard_session=signed(session, signer),
        draw=msgspec.UNSET if drawing is None else drawing.to_dict(),
    )
    made: dict[str, Any] = msgspec.to_builtins(make_export(bare, played, leaves.lookup))
    return made


def restored() -> dict[str, Any]:
    """An export after trouble: a backup that lacks the last two drops was restored.

    It was the second restore, so its log has an id. Then the server changed its key.
    """
    log = "a1" * 16
    whole = honest(signer=FORMER, log=log)
    kept = honest(2, signer=FORMER, log=log, void="b2" * 16)
    change = KeyStatement(SIGNER.public.hex(), FORMER.public.hex(), 3000)
    both = [signed(change, each) for each in (SIGNER, FORMER)]
    names = ("receipt", "index", "root", "signature")
    head = Signed(kept["head"]["statement"], SIGNER.sign(kept["head"]["statement"]).hex())
    return kept | {
        "key": SIGNER.public.hex(),
        "head": msgspec.to_builtins(head),
        "heard": [{name: each[name] for name in names} for each in whole["drops"]],
        "keys": [msgspec.to_builtins(both[0]) | {"former_signature": both[1].signature}],
    }


def ended(seed: int, aim: float | None) -> DropResult:
    found = drop(BOARD, seed, aim=aim)
    return DropResult(
        bin=found.bin,
        score=found.score,
        t=found.duration,
        x_end=found.x_end,
        digest=found.digest,
        unsettled=found.unsettled,
        payout=payout_of(100, found.score),
    )
