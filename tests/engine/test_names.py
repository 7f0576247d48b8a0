"""The package's public names, and what importing it loads."""

import pytest

import plinko
from plinko import engine
from tests.kit.python import run_python


def test_every_public_name_exists_and_is_listed_before_its_use() -> None:
    code = (
        "from plinko import engine\n"
        "listed = dir(engine)\n"
        "print(*(name for name in engine.__all__ if name not in listed))\n"
        "for name in engine.__all__: getattr(engine, name)\n"
    )
    assert run_python(code).split() == []
    assert len(set(engine.__all__)) == len(engine.__all__)


def test_an_unknown_name_is_reported_as_unknown() -> None:
    with pytest.raises(AttributeError, match=r"module 'plinko\.engine' has no attribute 'Pinball'"):
        _ = engine.Pinball  # type: ignore[attr-defined]


def test_a_drop_and_a_world_load_nothing_of_balls_that_touch() -> None:
    code = (
        "import sys\n"
        "from plinko.engine import Board, World, drop\n"
        "board = Board.preset('triangle-8')\n"
        "drop(board, 1)\n"
        "World(board, solver='stepped').add(1)\n"
        "print(*sorted(name for name in sys.modules if 'multibody' in name))\n"
    )
    assert run_python(code).split() == []


def test_without_python_flint_only_certified_names_are_missing() -> None:
    code = (
        "import inspect, sys\n"
        "sys.modules['flint'] = None\n"
        "import plinko, plinko.engine\n"
        "for package in (plinko.engine, plinko):\n"
        "    exec(f'from {package.__name__} import *')\n"
        "    print(drop(Board.preset('triangle-8'), 42).bin)\n"
        "    print(hasattr(package, 'certify'), 'Certificate' in package.__all__)\n"
        "    print(len(inspect.getmembers(package)) > 20)\n"
        "    print(bool(help(package)))\n"
        "    try: package.certify\n"
        "    except AttributeError as error: print(error)\n"
    )
    said = run_python(code)
    assert said.count("\nFalse False\nTrue\n") == 2
    missing = "certify needs python-flint: pip install 'plinko-sim[certify]'\n"
    assert said.count(missing) == 2
    assert said.endswith(missing)


def test_plinko_is_the_engine_by_another_name() -> None:
    assert plinko.__all__ == ["InvalidValueError", *engine.__all__, *plinko.PICTURES]
    assert all(getattr(plinko, name) is getattr(engine, name) for name in engine.__all__)
    assert dir(plinko) == sorted(plinko.__all__)
    assert dir(engine) == sorted(engine.__all__)
    with pytest.raises(AttributeError, match=r"module 'plinko\.engine' has no attribute 'Pinball'"):
        _ = plinko.Pinball  # type: ignore[attr-defined]


def test_plinko_loads_no_more_than_the_engine_does() -> None:
    loaded = "print(*sorted(n for n in sys.modules if n[:6] == 'plinko'))"
    before, used = run_python(f"import sys, plinko; {loaded}; plinko.Board; {loaded}").splitlines()
    assert before == "plinko"
    assert used == run_python(f"import sys; from plinko import engine; {loaded}").strip()


def test_plinko_loads_the_code_for_pictures_when_it_draws_one() -> None:
    code = (
        "import sys, plinko\n"
        "print('PIL' in sys.modules)\n"
        "print(plinko.drop_picture(plinko.drop('triangle-8', 1))[1:4])\n"
    )
    assert run_python(code).split() == ["False", "b'PNG'"]
