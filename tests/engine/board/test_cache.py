"""The cache of values made of boards, limited by their bytes."""

from concurrent.futures import ThreadPoolExecutor

from plinko.engine import Board
from plinko.engine.board.cache import BoardCache
from plinko.engine.board.fields import BoardFields


def boards(count: int) -> list[Board]:
    form = Board.preset("triangle-8").to_dict()
    return [Board.from_json({**form, "name": f"board {n}"}) for n in range(count)]


def kept(most: int, size: int = 10) -> tuple[BoardCache[bytes], list[BoardFields]]:
    """A cache whose values have `size` bytes, and the list of boards for which it made one."""
    made: list[BoardFields] = []

    def make(board: BoardFields) -> bytes:
        made.append(board)
        return bytes(size)

    return BoardCache(make, len, most), made


def test_what_is_kept_is_made_once() -> None:
    values, made = kept(30)
    first, second, third = boards(3)
    for board in (first, second, first, third, first):
        assert values(board) is values(board)
    assert made == [first, second, third]


def test_the_longest_unused_is_forgotten_beyond_the_bytes() -> None:
    values, made = kept(20)
    first, second, third = boards(3)
    for board in (first, second, first, third, first, second):
        values(board)
        assert values.bytes <= 20
    assert made == [first, second, third, second]


def test_what_is_larger_than_all_that_may_be_kept_is_kept_alone() -> None:
    values, made = kept(5)
    first, second = boards(2)
    for board in (first, first, second, second, first):
        values(board)
    assert made == [first, second, first]
    assert values.bytes == 10


def test_threads_that_want_the_same_at_once_make_it_once() -> None:
    values, made = kept(1000)
    few = boards(4)
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(values, few * 200))
    for number, board in enumerate(few):
        assert {id(each) for each in found[number::4]} == {id(values(board))}
    assert values.bytes == 40
    assert set(made) == set(few)
