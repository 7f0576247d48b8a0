"""A draw over a board: exact odds for its bins, and for each bin a list of seeds that land there.

The draw picks a bin by weight, then one of its seeds. Nothing steers the ball: the physics takes
that seed's ball into that bin anyway. Pure. See docs/fair-sessions.md.
"""

import hashlib
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, Final

from plinko.app.errors import InvalidValueError
from plinko.app.protocol.messages import DrawOdds
from plinko.app.rooms.canonical import canonical
from plinko.engine import Board, drop_many
from plinko.engine.drops.draws import check_weights
from plinko.engine.errors import ParameterError, SeedError
from plinko.engine.seeding import parse_seed

KIND: Final = "plinko draw"
VERSION: Final = 1

MAX_SEEDS: Final = 10_000
"""In one draw: 230 kB of JSON, and a second or two of a core to drop them."""

_NAMED: Final = 10  # misplaced seeds that an error lists; it counts the rest


@dataclass(frozen=True, eq=False)
class Draw:
    """The weight and the seeds of each bin of `board`, from left to right."""

    board: Board
    weights: tuple[int, ...]
    seeds: tuple["array[int]", ...]

    @classmethod
    def of(cls, board: Board, weights: object, seeds: object) -> "Draw":
        """Parse JSON values without dropping the seeds; raises InvalidValueError."""
        try:
            weighed = check_weights(board, weights)
        except ParameterError as error:
            raise InvalidValueError(str(error), field=f"draw.{error.field}") from error
        if not isinstance(seeds, Sequence) or len(seeds) != len(weighed):
            raise InvalidValueError(
                f"draw.seeds is not a list of {len(weighed)} lists, one for each bin of the board",
                field="draw.seeds",
            )
        lists = tuple(_seeds(bin_, listed) for bin_, listed in enumerate(seeds))
        for bin_, (weight, listed) in enumerate(zip(weighed, lists, strict=True)):
            if bool(weight) != bool(listed):
                what = "needs at least one seed" if weight else "can have no seeds"
                raise InvalidValueError(
                    f"draw.seeds[{bin_}] has {len(listed)} seeds: a bin with the weight {weight} "
                    f"{what}",
                    field=f"draw.seeds[{bin_}]",
                )
        count = sum(map(len, lists))
        if count > MAX_SEEDS:
            raise InvalidValueError(
                f"draw.seeds has {count} seeds in all; a draw has at most {MAX_SEEDS}",
                field="draw.seeds",
            )
        return cls(board, weighed, lists)

    @classmethod
    def checked(cls, board: Board, weights: object, seeds: object) -> "Draw":
        """Parse JSON values and drop each seed; raises InvalidValueError for a misplaced seed."""
        draw = cls.of(board, weights, seeds)
        draw.check_seeds()
        return draw

    @classmethod
    def of_values(cls, board: Board, values: Mapping[str, Any]) -> "Draw":
        """Parse what `to_dict` returned; raises InvalidValueError for any other JSON object."""
        fields = {"kind", "version", "board_digest", "weights", "seeds"}
        if values.keys() != fields:
            names, wanted = ", ".join(sorted(values)), ", ".join(sorted(fields))
            raise InvalidValueError(
                f"the draw has the fields {names}; it must have: {wanted}", field="draw"
            )
        found = cls.of(board, values["weights"], values["seeds"])
        if found.to_dict() != values:
            raise InvalidValueError(
                f"the draw is not a {KIND!r} of version {VERSION} over board {board.digest}, with "
                "its seeds as decimal texts",
                field="draw",
            )
        return found

    def to_dict(self) -> dict[str, Any]:
        """The JSON form, which `digest` hashes."""
        return {
            "kind": KIND,
            "version": VERSION,
            "board_digest": self.board.digest,
            "weights": list(self.weights),
            "seeds": [[str(seed) for seed in listed] for listed in self.seeds],
        }

    def to_json(self) -> bytes:
        """The canonical bytes of `to_dict`."""
        return canonical(self.to_dict())

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the canonical JSON, 64 hex digits."""
        return hashlib.sha256(self.to_json()).hexdigest()

    @property
    def odds(self) -> DrawOdds:
        """The public part, shown with the room: the digest and the weights."""
        return DrawOdds(self.digest, list(self.weights))

    @cached_property
    def _limits(self) -> list[int]:
        """For each bin, the sum of the weights up to and including it."""
        return list(accumulate(self.weights))

    def pick(self, mac: bytes) -> tuple[int, int]:
        """The bin and the seed for the 32 bytes of an HMAC, in integer arithmetic.

        The first 16 bytes pick the bin, the next 8 the seed.
        """
        x, y = int.from_bytes(mac[:16], "big"), int.from_bytes(mac[16:24], "big")
        place = x * self._limits[-1] >> 128
        bin_ = next(each for each, limit in enumerate(self._limits) if place < limit)
        listed = self.seeds[bin_]
        return bin_, listed[y * len(listed) >> 64]

    def check_seeds(self) -> None:
        """Drop every seed; raises InvalidValueError that lists those landing in another bin."""
        flat = [seed for listed in self.seeds for seed in listed]
        landed = drop_many(self.board, flat, threads=1).bin.tolist()
        places = [(bin_, i) for bin_, listed in enumerate(self.seeds) for i in range(len(listed))]
        wrong = [
            (f"draw.seeds[{bin_}][{i}]", seed, found)
            for (bin_, i), seed, found in zip(places, flat, landed, strict=True)
            if found != bin_
        ]
        if wrong:
            named = "; ".join(
                f"{place}: the ball of seed {seed} "
                + ("lands in no bin" if found < 0 else f"lands in bin {found}")
                for place, seed, found in wrong[:_NAMED]
            )
            more = f"; and {len(wrong) - _NAMED} more" if len(wrong) > _NAMED else ""
            raise InvalidValueError(named + more, field=wrong[0][0])


def _seeds(bin_: int, listed: object) -> "array[int]":
    if not isinstance(listed, Sequence) or isinstance(listed, str):
        raise InvalidValueError(
            f"draw.seeds[{bin_}] is not a list of seeds", field=f"draw.seeds[{bin_}]"
        )
    found = array("Q")
    for number, seed in enumerate(listed):
        try:
            found.append(parse_seed(seed))
        except SeedError as error:
            place = f"draw.seeds[{bin_}][{number}]"
            raise InvalidValueError(f"{place}: {error}", field=place) from error
    return found
