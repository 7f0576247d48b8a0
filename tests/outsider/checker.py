"""Digests, starts and payouts by docs/records.md and docs/boards.md, without the project's code."""

import hashlib
import json
import struct
from decimal import ROUND_FLOOR, Decimal
from typing import Any

Json = dict[str, Any]

MASK = 2**64 - 1


def floats(*values: float) -> bytes:
    return b"".join(struct.pack("<d", value + 0.0) for value in values)


def u32(value: int) -> bytes:
    return struct.pack("<I", value)


# Boards.


def completed(form: Json) -> Json:
    """A board's JSON with the defaults of docs/boards.md filled in."""
    board: Json = {"name": "board", "width": 8.0, "height": 6.0, "gravity": 9.81, "drag": 0.0}
    board |= {"pegs": [], **form}
    board["ball"] = {"radius": 0.08, "density": 1.0, "restitution": 0.6, "friction": 0.0} | (
        form.get("ball", {})
    )
    for part in ("peg_material", "wall_material"):
        board[part] = {"restitution": 0.6, "friction": 0.0} | form.get(part, {})
    board["drop"] = {"x": 0.0, "y": 0.0, "jitter": 0.0, "slots": [], "reach": 0.0, "aim": 0.0} | (
        form.get("drop", {})
    )
    board["bins"] = completed_bins(form.get("bins", {}), board["width"], board["height"])
    if "walls" not in form:
        top = board["drop"]["y"] - 2 * board["ball"]["radius"]
        edges, y = board["bins"]["edges"], board["bins"]["y"]
        board["walls"] = [{"x1": x, "y1": top, "x2": x, "y2": y} for x in (edges[0], edges[-1])]
    return board


def completed_bins(bins: Json, width: float, height: float) -> Json:
    multipliers = bins.get("multipliers", [1.0] * (len(bins.get("edges", [0, 0])) - 1))
    count = len(multipliers)
    equal = [width * (2 * i - count) / (2 * count) for i in range(count + 1)]
    return {
        "y": bins.get("y", height),
        "edges": bins.get("edges", equal),
        "multipliers": multipliers,
        "labels": bins.get("labels", []),
    }


def board_digest(form: Json) -> str:
    board = completed(form)
    name, ball, bins, drop = board["name"].encode(), board["ball"], board["bins"], board["drop"]
    parts = [b"plinko-board/1\n", u32(len(name)), name]
    parts.append(floats(board["width"], board["height"], board["gravity"], board["drag"]))
    parts.append(floats(*(ball[k] for k in ("radius", "density", "restitution", "friction"))))
    for things, keys, material in (
        ("pegs", ("x", "y", "radius"), "peg_material"),
        ("walls", ("x1", "y1", "x2", "y2"), "wall_material"),
    ):
        parts.append(u32(len(board[things])))
        parts += [floats(*(thing[key] for key in keys)) for thing in board[things]]
        parts.append(floats(board[material]["restitution"], board[material]["friction"]))
    parts.append(floats(bins["y"]))
    for numbers in (bins["edges"], bins["multipliers"]):
        parts += [u32(len(numbers)), floats(*numbers)]
    parts.append(floats(drop["x"], drop["y"], drop["jitter"]))
    parts += [u32(len(drop["slots"])), floats(*drop["slots"])]
    labels = bins["labels"] if any(bins["labels"]) else []
    parts += [floats(drop["reach"])] if drop["reach"] or drop["aim"] or labels else []
    parts += [floats(drop["aim"])] if drop["aim"] or labels else []
    parts += [u32(len(labels))] if labels else []
    for label in labels:
        for text in (label["text"], label.get("colour") or "") if label else ("", ""):
            parts += [u32(len(text.encode())), text.encode()]
    return hashlib.sha256(b"".join(parts)).hexdigest()


# Drops.


def start(seed: int, x: float, jitter: float) -> float:
    z = (seed + 0x9E3779B97F4A7C15) & MASK
    z = ((z ^ z >> 30) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ z >> 27) * 0x94D049BB133111EB) & MASK
    z = z ^ z >> 31
    fraction = (z >> 11) * 2.0**-53
    return x + jitter * (2 * fraction - 1)


def solver_bytes(record: Json) -> bytes:
    if record["solver"] == "exact":
        return b"\x00"
    values = record["dt"], record["substeps"], record["correction"]
    return b"\x01" + struct.pack("<dId", *values)


def drop_digests(record: Json, form: Json) -> list[str]:
    """Digests that a record may have: one if it landed, otherwise one for each way not to land."""
    zone = completed(form)["drop"]
    x = record.get("x")
    if x is None:
        x = start(int(record["seed"]), record.get("aim", zone["x"]), zone["jitter"])
    head = b"plinko drop" + bytes.fromhex(record["board_digest"])
    head += u32(record["physics_version"]) + solver_bytes(record)
    head += floats(x, zone["y"], 0.0, 0.0, 0.0)
    events = b"".join(struct.pack("<6d2i", *row[:6], *row[6:]) for row in record["impacts"])
    count = struct.pack("<Q", len(record["impacts"]))
    ways = [0] if record["bin"] is not None else [1, 2, 3, 4, 5]
    return [hashlib.sha256(head + bytes([way]) + count + events).hexdigest() for way in ways]


def record_errors(record: Json, form: Json) -> list[str]:
    """The wrong fields of a record, as far as the record and its board `form` show."""
    wrong = []
    bins = completed(form)["bins"]
    if record["board_digest"] != board_digest(form):
        wrong.append("board_digest")
    if record["digest"] not in drop_digests(record, form):
        wrong.append("digest")
    if record["bin"] is None:
        return wrong + ["score"] * (record["score"] != 1)
    last = record["impacts"][-1]
    if (last[0], last[1]) != (record["duration"], record["x_end"]):
        wrong.append("end")
    if last[6:] != [5, record["bin"]]:
        wrong.append("landing")
    left, right = bins["edges"][record["bin"] : record["bin"] + 2]
    if not left <= record["x_end"] < right:
        wrong.append("bin")
    if record["score"] != bins["multipliers"][record["bin"]]:
        wrong.append("score")
    return wrong


def batch_digest(records: list[Json], block: int) -> str:
    blocks = [records[k : k + block] for k in range(0, len(records), block)]
    return tree_root([block_hash(each) for each in blocks]).hex()


def block_hash(records: list[Json]) -> bytes:
    first = records[0]
    sha = hashlib.sha256(b"\0plinko drops" + bytes.fromhex(first["board_digest"]))
    sha.update(u32(first["physics_version"]) + solver_bytes(first))
    for record in records:
        hits = sum(row[6] <= 1 for row in record["impacts"])
        where = -1 if record["bin"] is None else record["bin"]
        sha.update(struct.pack("<idid", where, record["duration"], hits, record["x_end"]))
    return sha.digest()


def tree_root(hashes: list[bytes]) -> bytes:
    if len(hashes) == 1:
        return hashes[0]
    left = 1
    while 2 * left < len(hashes):
        left *= 2
    both = tree_root(hashes[:left]) + tree_root(hashes[left:])
    return hashlib.sha256(b"\1" + both).digest()


# Logs.


def payout(stake: int, score: float) -> int:
    return int((Decimal(str(score)) * stake).to_integral_value(ROUND_FLOOR))


def canonical(value: Any) -> str:
    """Canonical JSON by RFC 8785, for the values that logs contain."""
    if isinstance(value, dict):
        members = (f"{canonical(key)}:{canonical(part)}" for key, part in sorted(value.items()))
        return "{" + ",".join(members) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(canonical, value)) + "]"
    if isinstance(value, float):
        return number(value)
    return json.dumps(value, ensure_ascii=False)


def number(value: float) -> str:
    """A double as JavaScript writes it: Python's digits, but an exponent only from 1e-7 down."""
    if value == int(value):
        return str(int(value))
    text = repr(value)
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e-")
    if int(exponent) > 6:
        return f"{mantissa}e-{int(exponent)}"
    return f"{Decimal(text):f}"


def log_digest(log: Json) -> str:
    entries = "drops" if "drops" in log else "inputs"
    head = {key: value for key, value in log.items() if key not in (entries, "digest")}
    told = [{k: v for k, v in each.items() if k not in ("name", "colour")} for each in log[entries]]
    lines = [canonical(part) + "\n" for part in (head, *told)]
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def log_errors(log: Json) -> list[str]:
    """The wrong parts of a log, as far as the log itself shows: its digest and its payouts."""
    wrong = ["digest"] * (log["digest"] != log_digest(log))
    for each in log.get("drops", []):
        result = each["result"]
        if result and result["payout"] != payout(each["stake"], result["score"]):
            wrong.append(f"drops[{each['ball']}].result.payout")
    return wrong
