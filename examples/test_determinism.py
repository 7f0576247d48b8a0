"""A test for your CI: the drops on which your product depends have not changed by a bit.

    pip install plinko-sim pytest
    pytest test_determinism.py

Copy this file, replace the board, and replace the constants by the output of
`python test_determinism.py`. A release that changes results has another `PHYSICS_VERSION`; this
test then fails on purpose.
"""

import plinko

BOARD = "triangle-16"  # or plinko.Board.from_json("my-board.json")

PHYSICS_VERSION = 6
BATCH = "bf22abff8e48ad3fec5b7393cc8f632f4ba3e0ae73516ffea28e65a4d493d7ca"
DROP = "402de057c20e083948766914db9f441728e77cde59c31398e182a1622dcf6a11"


def test_the_release_has_the_physics_of_these_digests():
    assert plinko.PHYSICS_VERSION == PHYSICS_VERSION


def test_a_thousand_drops_have_not_changed():
    assert plinko.drop_many(BOARD, 1000).digest == BATCH


def test_one_drop_has_not_changed_on_any_number_of_threads():
    assert plinko.drop(BOARD, seed=42).digest == DROP
    for threads in (1, 2):
        assert plinko.drop_many(BOARD, [42], threads=threads)[0].digest == DROP


if __name__ == "__main__":
    print(f"PHYSICS_VERSION = {plinko.PHYSICS_VERSION}")
    print(f'BATCH = "{plinko.drop_many(BOARD, 1000).digest}"')
    print(f'DROP = "{plinko.drop(BOARD, seed=42).digest}"')
