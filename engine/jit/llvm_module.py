"""Turns kernels into LLVM modules for any machine, from the LLVM code that numba compiles.

Numba compiles a function to LLVM code that is nearly independent of the machine, and the LLVM in
numba's dependency llvmlite can emit code for other machines. Numba's code calls few functions
outside of it: reference counts of arrays, which these kernels do not need, and sqrt, floor and
ceil. They are defined here; a target adds its own. Only this module depends on the form of numba's
code.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite.binding
from numba import config, njit

from plinko.engine.jit.kernel_compiler import RULES

_llvm: Any = llvmlite.binding  # not annotated
_njit: Any = njit
_config: Any = config

_SURROUNDINGS = """
define void @NRT_incref(ptr %array) alwaysinline { ret void }
define void @NRT_decref(ptr %array) alwaysinline { ret void }
declare double @llvm.sqrt.f64(double)
declare double @llvm.floor.f64(double)
declare double @llvm.ceil.f64(double)
define double @sqrt(double %x) alwaysinline {
  %root = call double @llvm.sqrt.f64(double %x)
  ret double %root
}
define double @floor(double %x) alwaysinline {
  %whole = call double @llvm.floor.f64(double %x)
  ret double %whole
}
define double @ceil(double %x) alwaysinline {
  %whole = call double @llvm.ceil.f64(double %x)
  ret double %whole
}
"""


@dataclass(frozen=True)
class Export:
    """A function to compile and numba's types of its arguments."""

    function: Callable[..., Any]
    takes: tuple[Any, ...]

    def entry(self, name: str, native: Any) -> str:
        """LLVM code of a function with this name that calls numba's function `native`.

        Numba's functions take two addresses before their arguments: for a result and for an error.
        """
        raise NotImplementedError


def loads(kinds: list[str], place: Callable[[int], str]) -> str:
    """LLVM code that loads values %a0, %a1 … of these types from the addresses `place(i)`."""
    return "".join(f"\n%a{i} = load {kind}, {place(i)}" for i, kind in enumerate(kinds))


def target_machine(triple: str, **options: Any) -> Any:
    """LLVM's target machine for `triple`, at its highest optimization level."""
    _llvm.initialize_all_targets()
    _llvm.initialize_all_asmprinters()
    return _llvm.Target.from_triple(triple).create_target_machine(opt=3, **options)


def optimized(
    exports: Mapping[str, Export], machine: Any, surroundings: str, *, simd: bool,
    rewritten: Callable[[str], str] = str,
) -> Any:  # fmt: skip
    """An optimized LLVM module with these functions; `rewritten` edits numba's code first.

    Raises RuntimeError unless NUMBA_OPT=0 keeps numba from optimizing: optimized code contains
    offsets for addresses of eight bytes, and WebAssembly's have four.
    """
    if int(_config.OPT) != 0:
        raise RuntimeError(f"NUMBA_OPT is {int(_config.OPT)}: it must be 0, for code that can move")
    module = _llvm.parse_assembly(_header(machine) + _SURROUNDINGS + surroundings)
    for name, export in exports.items():
        native, code = _compiled(export)
        code_of_one = _parsed(rewritten(code), machine)
        entry = export.entry(name, code_of_one.get_function(native))
        _merge_with_others(code_of_one)
        module.link_in(_parsed(entry, machine))  # first, as linking drops unreferenced functions
        module.link_in(code_of_one)
    _keep_inside(module, but=tuple(exports))
    _optimize(module, machine, simd)
    return module


@cache
def _compiled(export: Export) -> tuple[str, str]:
    """The name and LLVM code of a function that numba compiles, with all functions it calls."""
    compiled = _njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **RULES)(export.function)
    compiled.compile(export.takes)
    (made,) = compiled.overloads.values()
    return made.fndesc.llvm_func_name, compiled.inspect_llvm(export.takes)


_OF_THE_MACHINE = re.compile(r'"(target-cpu|target-features|tune-cpu)"="[^"]*"')
_HEADER = re.compile(r"^(target (triple|datalayout)|source_filename) = .*$", re.MULTILINE)
_ERROR = re.compile(r'ptr @"?\.const\.picklebuf\.[^ ,]+')  # an exception's arguments
_COUNTING = re.compile(
    r"^define [^\n]*@(NRT_incref|NRT_decref)\([^\n]*\{\n.*?^\}$", re.MULTILINE | re.DOTALL
)


def _parsed(code: str, machine: Any) -> Any:
    """Parse LLVM code that numba has written for this machine, as code for `machine`."""
    code = _COUNTING.sub(r"declare void @\1(ptr)", code)
    code = _ERROR.sub("ptr null", code)
    code = _OF_THE_MACHINE.sub("", _HEADER.sub("", code)).replace(" common ", " internal ")
    module = _llvm.parse_assembly(_header(machine) + code)
    module.verify()
    return module


def _header(machine: Any) -> str:
    layout = machine.target_data
    return f'target triple = "{machine.triple}"\ntarget datalayout = "{layout}"\n'


def _merge_with_others(module: Any) -> None:
    """Let the linker merge functions that several modules define.

    Numba's names are unique, so functions with one name are the same.
    """
    for each in module.functions:
        if not each.is_declaration and each.linkage.name != "internal":
            each.linkage = "linkonce_odr"


def _keep_inside(module: Any, *, but: str | tuple[str, ...]) -> None:
    """Make all symbols internal, except the functions `but`."""
    kept = (but,) if isinstance(but, str) else but
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name not in kept:
            each.linkage = "internal"


def _optimize(module: Any, machine: Any, simd: bool) -> None:
    options = _llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = simd
    builder = _llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
