"""The fast way to compile kernels, and all that touches numba's insides: no other file does.

What numba would do for all of Python, it does not do here. The names it takes for that are private
to numba, so `check` looks at the version and at the names before any of them is used; if something
is amiss kernels are compiled the plain way (kernel_compiler.py), slower and with the same bits.
"""

import gc
import inspect
import operator
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import numba
from numba import njit, types
from numba.core import compiler as numba_compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.cpu import CPUContext
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.typing.context import Context

from engine.jit.kernel_compiler import RULES

TRIED = ((0, 61), (0, 62), (0, 63), (0, 64), (0, 68))
"""Minor versions of numba that gave the golden digests this way."""

_njit: Any = njit  # its types leave out an option that is used below
_plain: Any = types.unliteral  # and this has none

_RULES = RULES | {
    "no_cfunc_wrapper": True,  # for callers in C, of which there are none
    "no_rewrites": True,  # of expressions of whole arrays
}
_INNER_RULES = _RULES | {"_nrt": False, "no_cpython_wrapper": True}

_OPERATORS = (bool, int, *{each for each in vars(operator).values() if callable(each)})
_ARRAY_MAKER = "__array__"  # numba's name for what makes an array of something like one
_PLAIN = (types.Number, types.Boolean, types.Array, types.Omitted)
_no_flags: Any = Flags
_hash_of: Any = Flags.__hash__

_IDLE_PASSES = frozenset(
    {
        "WithLifting", "InlineClosureLikes", "MakeFunctionToJitFunction",  # with, closures
        "RewriteDynamicRaises",  # exceptions
        "InlineInlinables", "InlineOverloads",  # functions that numba is told to copy; LLVM does
        "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass",  # literally
        "AnnotateTypes", "DumpParforDiagnostics",  # reports that nobody reads
    }
)  # fmt: skip
"""Numba's passes over a function for what no kernel has. One that had it would fail to compile."""


class _Options(Flags):
    """The options that a function is compiled with, which know at once whether they are equal.

    Numba keeps what it knows of an operation by types and options, and asks several times for each
    operation there is. Its own options then compare all of thirty values, set or not: a tenth of
    the time to compile. These compare what has been set, and do not change once they are asked.
    """

    __slots__ = ("_hash",)

    def __hash__(self) -> int:
        if not hasattr(self, "_hash"):
            self._hash: int = _hash_of(self)
        return self._hash

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Options):
            return NotImplemented
        return bool(self._values == other._values)


class _Meaning:
    """What numba takes a call of an operator for, with a memory for numbers, arrays and indices.

    Numba tries a dozen meanings of an operator, of texts, sets and dates too, wherever it stands:
    to find its type, to make code of it, and before that for each operand that is a constant, in
    vain. That is a quarter of the time to compile. The meaning depends on the types alone.
    """

    def __init__(self, ask: Callable[..., Any]) -> None:
        self._ask = ask
        self.known: dict[tuple[Any, ...], Any] = {}

    def __call__(self, context: Any, args: tuple[Any, ...], kws: Any) -> Any:
        """The signature of the call with these types of arguments; TypingError if there is none."""
        if kws or not all(map(_is_plain, args)):
            return self._ask(context, args, kws)
        if args not in self.known:
            try:
                self.known[args] = self._ask(context, args, kws)
            except TypingError as error:
                self.known[args] = error
        said = self.known[args]
        if isinstance(said, TypingError):
            raise TypingError(str(said))  # a new one: numba writes into those that it catches
        return said


def _is_plain(kind: Any) -> bool:
    if isinstance(kind, types.Tuple | types.UniTuple):
        return all(map(_is_plain, kind))
    return isinstance(kind, _PLAIN)


def _give_memory(context: Any) -> None:
    """To the operators that numba knows in `context`; whoever compiles here gets the same."""
    for operator_type in map(context._lookup_global, _OPERATORS):
        if operator_type is not None and not isinstance(operator_type.get_call_type, _Meaning):
            operator_type.get_call_type = _Meaning(operator_type.get_call_type)


class _Target(CPUContext):
    """Numba's target, which does not look up again what cannot have changed.

    Wherever an array is read numba looks for code that makes it of something else. As there never
    is any it loads all its registries anew and looks again: a fortieth of the time to compile. For
    the size of a type it writes a module of it and has LLVM read that: as much again.
    """

    _sizes: ClassVar[dict[str, int]] = {}  # bytes; by the type as LLVM writes it

    def get_abi_sizeof(self, ty: Any) -> int:
        """Bytes that a value of a type of LLVM takes in memory."""
        name = str(ty)
        if name not in self._sizes:
            size: Any = super().get_abi_sizeof
            self._sizes[name] = size(ty)
        return self._sizes[name]

    def get_function(self, fn: Any, sig: Any, _firstcall: bool = True) -> Any:
        """What makes code of a call of `fn`; NotImplementedError if there is nothing."""
        find: Any = super().get_function
        return find(fn, sig, _firstcall and fn != _ARRAY_MAKER)


class KernelCompiler(Compiler):
    """Numba's compiler with options, operators and target as above, without idle passes.

    Nor does it look for garbage meanwhile: what it makes is kept until the function is done, or for
    good, and to look through all of it again and again is another twentieth of the time. Other
    threads' garbage waits, too.
    """

    def define_pipelines(self) -> list[Any]:
        """Numba's, but for the idle passes."""
        define: Any = super().define_pipelines
        pipelines: list[Any] = define()
        for each in pipelines:
            each.passes = [one for one in each.passes if one[0].__name__ not in _IDLE_PASSES]
            each.finalize()
        return pipelines

    def compile_extra(self, function: Callable[..., object]) -> Any:
        """Compile `function`, and what it calls inside of this."""
        options: Any = _Options
        compile_it: Any = super().compile_extra
        self.state.flags = options(self.state.flags)
        _give_memory(self.state.typingctx)
        self.state.targetctx.__class__ = _Target  # numba made it for this function alone
        collects = gc.isenabled()
        gc.disable()
        try:
            return compile_it(function)
        finally:
            if collects:
                gc.enable()


class _InnerLibrary(JITCodeLibrary):
    """Code that is there to be linked into callers, and becomes machine code only inside of them.

    Numba would optimize it, make machine code of it and keep that, then optimize it once more in
    every caller: a tenth of the time to compile.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True


class InnerCompiler(KernelCompiler):
    """`KernelCompiler`, stopping before the machine code; for functions that are not cached."""

    def compile_extra(self, function: Callable[..., object]) -> Any:
        """Compile `function`; callers know it by its entry point, as which any new object does."""
        context = self.state.targetctx
        library: Any = _InnerLibrary
        self.state.library = library(context.codegen(), function.__qualname__)
        self.state.flags.no_compile = True
        found = super().compile_extra(function)._replace(entry_point=object())
        context.insert_user_function(found.entry_point, found.fndesc, [found.library])
        return found


def outer(function: Callable[..., Any], stamp: str) -> Any:
    """`decorator.kernel`; its code on disk is stale once `stamp` is another."""
    compiled = _without_literals(
        _njit(function, cache=True, pipeline_class=KernelCompiler, **_RULES)
    )
    if compiled is not function:  # else a configuration file of numba's turns the JIT off
        compiled._cache._cache_file._source_stamp = stamp
    return compiled


def inner(function: Callable[..., Any], forceinline: bool) -> Any:
    """`decorator.inner_kernel`, or with forceinline `lean_kernel`."""
    compiled = _without_literals(
        _njit(function, pipeline_class=InnerCompiler, forceinline=forceinline, **_INNER_RULES)
    )
    if compiled is not function:
        # Numba would call the wrapper that is not there. It is told of none, asks for one to be
        # compiled, and gets the function itself.
        compiled._insert = lambda *_, **__: None
        compiled._compile_for_args = lambda *_, **__: function
    return compiled


def _without_literals(compiled: Any) -> Any:
    if hasattr(compiled, "get_call_template"):
        compiled.get_call_template = partial(_call_template, compiled.get_call_template)
    return compiled


def _call_template(original: Any, args: Any, kws: Any) -> Any:
    """What a call compiles: one function for all integers, instead of one for each constant too.

    Numba takes `kind=2` for a type of its own, and a variable for one until it has seen what else
    is assigned to it: a fifth of the time to compile would go into functions that nobody calls.
    """
    named = {name: _plain(kind) for name, kind in dict(kws).items()}
    return original(tuple(_plain(kind) for kind in args), named)


class UnknownNumbaError(ImportError):
    """This numba is not one that the fast way was tried with, or lacks a name that it takes."""


_TAKEN: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (_no_flags(), ("_values", "copy")),
    (Context, ("_lookup_global",)),
    (types.Function, ("get_call_type",)),
    (CPUContext, ("codegen", "get_abi_sizeof", "insert_user_function", "refresh", "subtarget")),
    (JITCodeLibrary, ("_optimize_final_module", "_finalize_final_module", "_finalized")),
    (Compiler, ("compile_extra", "define_pipelines")),
    (numba_compiler, tuple(_IDLE_PASSES)),
)
"""Names that are called or replaced above, by whom they belong to."""

_DISPATCHER = ("get_call_template", "_insert", "_compile_for_args", "_cache")
"""As `_TAKEN`, of a function that numba has been given."""

_FIND = ("self", "fn", "sig", "_firstcall")
"""Parameters of `CPUContext.get_function`."""


def check() -> None:
    """Raise UnknownNumbaError unless this numba was tried and has all names that are taken from it.

    Nothing is compiled for it: the first thing to be compiled has numba load all that it knows,
    0.2 seconds that a program need not pay which imports the engine and drops no ball.
    """
    minor = tuple(numba.__version__.split(".")[:2])
    tried = [f"{major}.{each}" for major, each in TRIED]
    if ".".join(minor) not in tried:
        raise UnknownNumbaError(
            f"numba {numba.__version__} is none of those tried, {', '.join(tried)}"
        )
    for owner, names in _TAKEN:
        _demand(owner, names)
    if tuple(inspect.signature(CPUContext.get_function).parameters) != _FIND:
        raise UnknownNumbaError(f"numba's CPUContext.get_function does not take {', '.join(_FIND)}")
    made = _njit(_halved, cache=True, **_RULES)
    if made is _halved:  # a configuration file of numba's turns the JIT off
        return
    _demand(made, _DISPATCHER)
    _demand(made._cache, ("_cache_file",))
    _demand(made._cache._cache_file, ("_source_stamp",))
    read: Any = cpu_target.options.parse_as_flags
    read(
        _no_flags(), _INNER_RULES | {"forceinline": True}
    )  # KeyError for an option it does not know


def _demand(owner: Any, names: tuple[str, ...]) -> None:
    for name in names:
        if not hasattr(owner, name):
            called = getattr(owner, "__name__", type(owner).__name__)
            raise UnknownNumbaError(f"numba {numba.__version__} has no {called}.{name}")


def _halved(x: float) -> float:
    return 0.5 * x
