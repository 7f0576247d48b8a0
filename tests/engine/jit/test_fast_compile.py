"""The fast way: sooner than numba would compile by itself, with the same meaning."""

import gc
import operator
import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numba import literal_unroll, njit, types
from numba.core import compiler as numba_compiler
from numba.core.compiler import Compiler, Flags
from numba.core.cpu import CPUContext
from numba.core.errors import NumbaError, TypingError
from numba.core.registry import cpu_target
from numba.core.typing.templates import signature

from engine.jit import decorator, fast_compile

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")


def compiled(function: Callable[..., Any]) -> Any:
    """`function` as a kernel, but compiled in this process whatever is on disk."""
    make: Any = njit
    return make(function, pipeline_class=fast_compile.KernelCompiler, **fast_compile._RULES)


def mean_square(values: Any, count: int) -> float:
    total = 0.0
    for i in range(int(count)):
        total += values[i] * values[i] / count
    return total


@pytest.fixture
def collecting() -> Iterator[None]:
    """The search for garbage is on, and after the test as it was found."""
    was = gc.isenabled()
    gc.enable()
    yield
    (gc.enable if was else gc.disable)()


def numba_says(function: Any, args: tuple[Any, ...]) -> Any:
    """The meaning of a call by numba without a memory; None if there is none."""
    kind = cpu_target.typing_context.resolve_value_type(function)
    try:
        return type(kind).get_call_type(kind, cpu_target.typing_context, args, {})
    except TypingError:
        return None


def test_what_is_remembered_of_operators_is_what_numba_says() -> None:
    assert compiled(mean_square)(np.array([3.0, 4.0]), 2) == 12.5
    remembered = 0
    for function in (operator.iadd, operator.mul, operator.truediv, operator.getitem, bool, int):
        meaning = cpu_target.typing_context.resolve_value_type(function).get_call_type
        remembered += len(meaning.known)
        for args, said in meaning.known.items():
            expected = numba_says(function, args)
            assert said == expected or (expected is None and isinstance(said, TypingError))
    assert remembered >= 5


def test_nothing_is_remembered_of_functions_and_of_other_types() -> None:
    context = cpu_target.typing_context
    compiled(mean_square)(np.array([3.0, 4.0]), 2)
    for function in (np.add, np.sqrt, len):
        asked = context.resolve_value_type(function).get_call_type
        assert not isinstance(asked, fast_compile._Meaning)
    plus = context.resolve_value_type(operator.add).get_call_type
    texts = (types.unicode_type, types.unicode_type)
    assert plus(context, texts, {}) == numba_says(operator.add, texts)
    assert texts not in plus.known


def target() -> Any:
    """What a kernel is compiled for."""
    found: Any = cpu_target.target_context.subtarget()
    found.__class__ = fast_compile._Target
    return found


def test_a_type_has_the_size_that_numba_says() -> None:
    numbas = cpu_target.target_context
    several: Any = types.Tuple
    kinds = (types.int8, types.float64, types.boolean, types.complex128, types.float64[:, ::1])
    for kind in (*kinds, several((types.int32,) * 3), several((types.int8, types.float64))):
        asked = numbas.get_value_type(kind)
        size = numbas.get_abi_sizeof(asked)
        assert [target().get_abi_sizeof(asked) for _ in range(2)] == [size, size]


def test_numba_looks_for_news_except_of_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    refreshed = []

    def spy(self: CPUContext) -> None:
        refreshed.append(self)

    monkeypatch.setattr(CPUContext, "refresh", spy)
    call: Any = signature
    for made, count in (("__array__", 0), ("no such function", 1)):
        with pytest.raises(NotImplementedError):
            target().get_function(made, call(types.float64[::1], types.float64[::1]))
        assert len(refreshed) == count


def test_kernels_are_compiled_for_that_target() -> None:
    function = compiled(mean_square)
    function(np.ones(3), 3)
    (made,) = function.overloads.values()
    assert type(made.target_context) is fast_compile._Target


def test_what_has_no_meaning_is_refused_every_time() -> None:
    def nonsense(values: Any, count: int) -> Any:
        return count[values]  # type: ignore[index]

    for _ in range(2):
        with pytest.raises(TypingError, match="getitem"):
            compiled(nonsense)(np.zeros(2), 3)


def test_options_are_equal_if_the_same_has_been_set() -> None:
    options: Any = fast_compile._Options
    numba_options: Any = Flags
    given = numba_options()
    given.release_gil = True
    one, same, other = options(given), options(given), options(given)
    other.nrt = True
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert one == given  # numba's own, compared numba's way
    assert other != given
    assert one.copy() == one
    assert type(one.copy()) is options


@pytest.mark.usefixtures("collecting")
def test_garbage_waits_until_a_kernel_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    original: Any = Compiler.compile_extra

    def spy(self: Compiler, function: Callable[..., Any]) -> Any:
        seen.append(gc.isenabled())
        return original(self, function)

    monkeypatch.setattr(Compiler, "compile_extra", spy)
    compiled(mean_square)(np.ones(3), 3)
    assert seen[0] is False
    assert gc.isenabled()

    def fails(values: Any) -> Any:
        return values.no_such_thing

    with pytest.raises(TypingError):
        compiled(fails)(np.ones(3))
    assert gc.isenabled()

    gc.disable()
    compiled(mean_square)(np.ones(3, np.float32), 3)
    assert not gc.isenabled()


def test_an_inner_kernel_makes_no_arrays_even_where_a_kernel_did() -> None:
    def filled(count: int) -> Any:
        made = np.zeros(count)
        made[0] = 1.0
        return made

    assert compiled(filled)(3).tolist() == [1.0, 0.0, 0.0]
    inside: Any = decorator.inner_kernel(filled)

    def outside(count: int) -> float:
        return float(inside(count)[0])

    with pytest.raises(TypingError, match="zeros"):
        compiled(outside)(3)


def test_what_an_idle_pass_would_do_is_refused() -> None:
    """A kernel with a closure, or different types in a loop, fails: it means nothing else."""

    def closed(values: Any) -> float:
        def twice(x: float) -> float:
            return 2.0 * x

        return twice(values[0])

    def listed(values: Any) -> float:
        total = 0.0
        for each in literal_unroll((1, 2.0)):
            total += each * values[0]
        return total

    for function in (closed, listed):
        with pytest.raises(NumbaError):
            compiled(function)(np.ones(1))


def test_the_idle_passes_are_numbas() -> None:
    """Under another name they would run again, unnoticed."""
    passes = {name for name in vars(numba_compiler) if name in fast_compile._IDLE_PASSES}
    assert passes == fast_compile._IDLE_PASSES
