"""Check a fair session offline from its export, independently of the project's checker.

    python verify_session.py session.json [KEY]

Written from docs/fair-sessions.md. It needs the package `cryptography` for Ed25519. To recompute
the paths of the drops it needs `plinko` (pip install plinko-sim), or your own solver, which
docs/reproduce.md describes completely. Exit code 1 if any check fails.
"""

import hashlib
import hmac
import json
import sys
from decimal import Decimal

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey


def once(members):
    """The members of a JSON object; refuses a key given twice, of which readers keep either."""
    found = dict(members)
    if len(found) < len(members):
        keys = [key for key, _ in members]
        sys.exit(f"{next(key for key in keys if keys.count(key) > 1)!r}: the key is given twice")
    return found


def canonical(value):
    """The session's JSON by RFC 8785: sorted keys, no spaces, numbers as in JavaScript."""
    if isinstance(value, dict):
        parts = (f"{json.dumps(key)}:{canonical(value[key])}" for key in sorted(value))
        return "{" + ",".join(parts) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(canonical, value)) + "]"
    if isinstance(value, float):
        if value.is_integer():
            return str(int(value))
        text = repr(value)
        if abs(value) >= 1e-6:
            return f"{Decimal(text):f}"
        digits, _, exponent = text.partition("e")
        return f"{digits}e{int(exponent)}"
    return json.dumps(value, ensure_ascii=False)


def is_signed_by(key, statement, signature):
    """Whether the statement has the Ed25519 signature of this public key."""
    try:
        Ed25519PublicKey.from_public_bytes(bytes.fromhex(key)).verify(
            bytes.fromhex(signature), canonical(statement).encode()
        )
    except (InvalidSignature, ValueError):
        return False
    return True


def server_keys(export, known=None):
    """The server's keys, latest first, and whether `known` is one that leads to the latest.

    The list ends before the first change that the later key has not signed.
    """
    keys, leads = [export["key"]], known in (None, export["key"])
    handed_on = True  # whether each key so far was signed by the one before it
    for change in export.get("keys", ()):
        statement, given = change["statement"], change["former_signature"]
        if statement["key"] != keys[-1] or statement["kind"] != "plinko key":
            break
        if not is_signed_by(keys[-1], statement, change["signature"]):
            break
        keys.append(statement["former"])
        handed_on = handed_on and given is not None and is_signed_by(keys[-1], statement, given)
        leads = leads or (handed_on and keys[-1] == known)
    return keys, leads


def drop_seed(server_seed, client_seed, number, board_digest):
    """The seed of a drop: the first 8 bytes of an HMAC, big-endian."""
    message = b"plinko drop 1\n" + client_seed + number.to_bytes(8, "big") + board_digest
    return int.from_bytes(hmac.digest(server_seed, message, "sha256")[:8], "big")


def drawn(draw, server_seed, client_seed, number, board_digest):
    """The bin and the seed of a drop in a room with a draw, from another HMAC."""
    message = b"plinko draw 1\n" + client_seed + number.to_bytes(8, "big") + board_digest
    mac = hmac.digest(server_seed, message, "sha256")
    place = int.from_bytes(mac[:16], "big") * sum(draw["weights"]) >> 128
    for bin_, weight in enumerate(draw["weights"]):
        if place < weight:
            seeds = draw["seeds"][bin_]
            return bin_, seeds[int.from_bytes(mac[16:24], "big") * len(seeds) >> 64]
        place -= weight
    raise ValueError("the weights are all 0")


def leaf_hash(leaf):
    return hashlib.sha256(b"\x00" + leaf).digest()


def node_hash(left, right):
    return hashlib.sha256(b"\x01" + left + right).digest()


def root_by_inclusion(leaf, index, size, proof):
    """The root that an inclusion proof gives for this leaf (RFC 9162, 2.1.3.2)."""
    place, last, digest = index, size - 1, leaf_hash(leaf)
    for sibling in proof:
        if place & 1 or place == last:
            digest = node_hash(sibling, digest)
            while not place & 1 and place:
                place, last = place >> 1, last >> 1
        else:
            digest = node_hash(digest, sibling)
        place, last = place >> 1, last >> 1
    return digest if last == 0 else None


def roots_by_consistency(first, second, first_root, proof):
    """The old and the new root that a consistency proof gives (RFC 9162, 2.1.4.2)."""
    if first == second:
        return first_root, first_root
    path = [first_root, *proof] if first & (first - 1) == 0 else list(proof)
    place, last = first - 1, second - 1
    while place & 1:
        place, last = place >> 1, last >> 1
    old = new = path[0]
    for sibling in path[1:]:
        if place & 1 or place == last:
            old, new = node_hash(sibling, old), node_hash(sibling, new)
            while not place & 1 and place:
                place, last = place >> 1, last >> 1
        else:
            new = node_hash(new, sibling)
        place, last = place >> 1, last >> 1
    return (old, new) if last == 0 else (None, None)


def failures(export, key=None):
    """The claims that do not hold in a session, without those about its paths."""
    session, head, end = (export[name]["statement"] for name in ("session", "head", "end"))
    server_seed, client_seed = (
        bytes.fromhex(export[name]) for name in ("server_seed", "client_seed")
    )
    drops, draw = export["drops"], export.get("draw")
    keys, is_known = server_keys(export, key)

    def is_signed(signed):
        statement, signature = signed["statement"], signed["signature"]
        return any(is_signed_by(each, statement, signature) for each in keys)

    holds = {
        "the key is the one that you know": is_known,
        "each earlier key is named by the next one": len(keys) == 1 + len(export.get("keys", ())),
        "the statement is signed": is_signed(export["session"]),
        "the head of the log is signed": is_signed(export["head"]),
        "the end is signed": is_signed(export["end"]),
        "the statement is the one that you were given": export["heard_session"]
        in (None, export["session"]),
        "the server's seed is the one it committed to": hashlib.sha256(server_seed).hexdigest()
        == session["server_commitment"],
        "your seed is the one you committed to": hashlib.sha256(client_seed).hexdigest()
        == session["client_commitment"],
        "the end is this session's": (end["session"], end["server_seed"])
        == (session["session"], export["server_seed"]),
        "no drop is left out": [d["receipt"]["drop"] for d in drops] == list(range(end["drops"])),
        "the multipliers are those committed to": hashlib.sha256(
            canonical(export["board"]["bins"]["multipliers"]).encode()
        ).hexdigest()
        == session["payouts_digest"],
        "the draw is the one committed to": session.get("draw_digest")
        == (draw and hashlib.sha256(canonical(draw).encode()).hexdigest()),
        "the draw is of this board": draw is None
        or draw["board_digest"] == session["board_digest"],
    }
    size, root = head["size"], bytes.fromhex(head["root"])
    for number, drop in enumerate(drops):
        receipt, index = drop["receipt"], drop["index"]
        entry = {
            "kind": "plinko log entry", "version": 1,
            "receipt": receipt, "index": index, "root": drop["root"],
        }  # fmt: skip
        if "log" in head:  # one that began with the restore of a backup
            entry["log"] = head["log"]
        signed = {"statement": entry, "signature": drop["signature"]}
        known = (server_seed, client_seed, number, bytes.fromhex(session["board_digest"]))
        if draw is None:
            holds[f"drop {number}: both seeds draw its start"] = receipt["seed"] == str(
                drop_seed(*known)
            )
        else:
            bin_, seed = drawn(draw, *known)
            start = (receipt["seed"], receipt["aim"])
            holds |= {
                f"drop {number}: both seeds draw its bin": drop["result"]["bin"] == bin_,
                f"drop {number}: its ball is of that bin's list": start == (seed, None),
            }
        leaf, old = canonical(receipt).encode(), bytes.fromhex(drop["root"])
        inclusion, consistency = (
            [bytes.fromhex(node) for node in drop[name]] for name in ("inclusion", "consistency")
        )
        same = (receipt["session"], receipt["board_digest"])
        holds |= {
            f"drop {number}: the receipt is signed": is_signed(signed),
            f"drop {number}: it is of this session and board": same
            == (session["session"], session["board_digest"]),
            f"drop {number}: the log has it": root_by_inclusion(leaf, index, size, inclusion)
            == root,
            f"drop {number}: the log only grew": roots_by_consistency(
                index + 1, size, old, consistency
            )
            == (old, root),
        }
        highest = max(export["board"]["bins"]["multipliers"])
        largest = int(Decimal(repr(float(highest))) * receipt["stake"])
        holds[f"drop {number}: all it could pay is below 2^53"] = largest < 2**53
        paid = int(Decimal(repr(float(drop["result"]["score"]))) * receipt["stake"])
        holds[f"drop {number}: its payout"] = drop["result"]["payout"] == paid
    return [claim for claim, is_so in holds.items() if not is_so]


def path_failures(export):
    """Recompute the board's digest and the drops' paths; return the claims that do not hold."""
    import plinko

    board = plinko.Board.from_json(export["board"])
    session = export["session"]["statement"]
    said = (session["board_digest"], session["physics_version"])
    if said != (board.digest, plinko.PHYSICS_VERSION):
        return ["the board and the version of the physics"]
    failed = []
    for drop in export["drops"]:
        receipt, result = drop["receipt"], drop["result"]
        again = plinko.drop(board, receipt["seed"], aim=receipt["aim"])
        if (again.digest, again.bin, again.score) != tuple(
            result[name] for name in ("digest", "bin", "score")
        ):
            failed.append(f"drop {receipt['drop']}: every bit of its path")
    return failed


def main(name, key=None):
    with open(name, "rb") as file:
        export = json.loads(file.read(), object_pairs_hook=once)  # in any encoding of Unicode
    if export["end"] is None:
        sys.exit("the session has not ended: the server's seed is still secret")
    failed = failures(export, key) + path_failures(export)
    for claim in failed:
        print(f"does not hold: {claim}")
    if "void" in export["end"]["statement"]:
        print("a restored backup ended the session: drops that it lacks are void")
    if not failed:
        print(f"all of it holds: {len(export['drops'])} drops, key {export['key']}")
    if export["heard_session"] is None:
        print("not shown: that the server committed before it knew your seed; keep the first reply")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
