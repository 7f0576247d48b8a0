"""The package's public names, and what importing it loads."""

import pytest

import plinko
from plinko import engine
from tests.kit.python import run_python


def test_an_unknown_name_is_reported_as_unknown() -> None:
    with pytest.raises(AttributeError, match=r"module 'plinko\.engine' has no attribute 'Pinball'"):
        _ = engine.Pinball  # type: ignore[attr-defined]


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


def test_each_part_is_loaded_when_it_is_used() -> None:
    """`plinko` loads no more than the engine; drops nothing for touching balls or pictures."""
    loaded = "print(*sorted(name for name in sys.modules if name[:6] == 'plinko'))\n"
    engine_only, _, unlisted = run_python(
        f"import sys\nfrom plinko import engine\n{loaded}"
        "listed = dir(engine)\n"
        "for name in engine.__all__: getattr(engine, name)\n"
        "print()\n"
        "print(*(name for name in engine.__all__ if name not in listed))\n"
    ).split("\n", 2)
    assert unlisted == "\n"
    before, used, dropped, drawn = run_python(
        f"import sys, plinko\n{loaded}plinko.Board\n{loaded}"
        "plinko.World(plinko.Board.preset('triangle-8'), solver='stepped').add(1)\n"
        "one = plinko.drop('triangle-8', 1)\n"
        "print(*(name for name in sys.modules if 'multibody' in name or name == 'PIL'))\n"
        "print(plinko.drop_picture(one)[1:4])\n"
    ).splitlines()
    assert (before, used) == ("plinko", engine_only)
    assert (dropped, drawn) == ("", "b'PNG'")
