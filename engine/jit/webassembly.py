"""Kernels as WebAssembly: numba's LLVM code of some functions, made into one module.

Numba compiles a function to LLVM code, which is about as good for any machine; LLVM, which is in
numba's own wheel, can write it for WebAssembly. What numba's code asks of its surroundings is
little: to count the references of arrays, of which these functions make none, and a square root.
Both are given here. LLVM's result is an object file, a module but for the names of what it exports;
the last step adds these.

Only here is known what numba's code looks like.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import llvmlite.binding
from numba import config, njit, types
from numba.extending import intrinsic

from engine.jit.calls import BLOCK, HEAP, STATUS
from engine.jit.kernel_compiler import RULES
from engine.jit.wasm_sections import with_exports

_llvm: Any = llvmlite.binding  # which has no types
_njit: Any = njit
_types: Any = types
_config: Any = config
_intrinsic: Any = intrinsic

TRIPLE = "wasm32-unknown-unknown"

FEATURES = "+bulk-memory,+mutable-globals,+nontrapping-fptoint,+sign-ext"
"""What every engine has had for years. Neither threads nor relaxed SIMD: their results may differ
from machine to machine."""

SIMD = "+simd128"
"""Two numbers at a time, each with the bits that it has alone."""

FLOATS = _types.CPointer(types.float64)
INTS = _types.CPointer(types.int32)
WORDS = _types.CPointer(types.uint32)
LONGS = _types.CPointer(types.int64)
BYTES = _types.CPointer(types.int8)
INT = types.int32
FLOAT = types.float64

_PASSED = {INT: "i32", FLOAT: "double"}  # else an address

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
define {i64, i1} @product_of_sizes(i64 %a, i64 %b) alwaysinline {
  %product = mul i64 %a, %b
  %either = or i64 %a, %b
  %overflow = icmp ugt i64 %either, 2147483647
  %first = insertvalue {i64, i1} undef, i64 %product, 0
  %both = insertvalue {i64, i1} %first, i1 %overflow, 1
  ret {i64, i1} %both
}
declare i32 @llvm.wasm.memory.size.i32(i32)
declare i32 @llvm.wasm.memory.grow.i32(i32, i32)
declare void @llvm.trap() noreturn
define ptr @NRT_MemInfo_alloc_aligned(i64 %size, i32 %align) noinline {
  %at = load i32, ptr inttoptr (i32 HEAP to ptr)
  %small = trunc i64 %size to i32
  %padded = add i32 %small, 127
  %whole = and i32 %padded, -64
  %end = add i32 %at, %whole
  %pages = call i32 @llvm.wasm.memory.size.i32(i32 0)
  %room = shl i32 %pages, 16
  %fits = icmp ult i32 %end, %room
  br i1 %fits, label %done, label %more
more:
  %lacking = lshr i32 %whole, 16
  %asked = add i32 %lacking, 16
  %was = call i32 @llvm.wasm.memory.grow.i32(i32 0, i32 %asked)
  %failed = icmp eq i32 %was, -1
  br i1 %failed, label %full, label %done
full:
  call void @llvm.trap()
  unreachable
done:
  store i32 %end, ptr inttoptr (i32 HEAP to ptr)
  %info = inttoptr i32 %at to ptr
  %from = add i32 %at, 64
  %data = inttoptr i32 %from to ptr
  %field = getelementptr {i64, ptr, ptr, ptr, i64, ptr}, ptr %info, i32 0, i32 3
  store ptr %data, ptr %field
  ret ptr %info
}
""".replace("HEAP", str(HEAP))


@dataclass(frozen=True)
class Export:
    """A function of a module: what to compile, and the types that it takes. It returns nothing.

    Types are those above: numbers, and addresses in the module's memory.
    """

    function: Callable[..., None]
    takes: tuple[Any, ...]

    def entry(self, name: str, native: Any) -> str:
        """Code of a function by this name that calls numba's.

        Numba's take two addresses before all others, for a result and for an error. There are none.
        """
        kinds = [_PASSED.get(kind, "ptr") for kind in self.takes]
        given = ", ".join(f"{kind} %a{i}" for i, kind in enumerate(kinds))
        return f"""
        declare i32 @"{native.name}"(ptr, ptr{"".join(f", {kind}" for kind in kinds)})
        define void @"{name}"({given}) {{
          %result = alloca ptr
          %error = alloca ptr
          %status = call i32 @"{native.name}"(ptr %result, ptr %error, {given})
          ret void
        }}
        """


class Entry(Export):
    """A kernel of any arguments: its function of a module takes nothing, which costs the least.

    In a block there are eight bytes for each number that numba's code takes. Behind it the result
    is left, and numba's code of how it ended at STATUS.
    """

    def entry(self, name: str, native: Any) -> str:
        """Code of a function by this name that calls numba's."""
        kinds = [str(each.type) for each in native.arguments][2:]
        loads = "".join(
            f"""
            %a{i} = load {kind}, ptr inttoptr (i32 {BLOCK + 8 * i} to ptr)"""
            for i, kind in enumerate(kinds)
        )
        given = "".join(f", {kind} %a{i}" for i, kind in enumerate(kinds))
        result = f"ptr inttoptr (i32 {BLOCK + 8 * len(kinds)} to ptr)"
        return f"""
        declare i32 @"{native.name}"(ptr, ptr{"".join(f", {kind}" for kind in kinds)})
        define void @"{name}"() {{
          %error = alloca ptr{loads}
          %status = call i32 @"{native.name}"({result}, ptr %error{given})
          store i32 %status, ptr inttoptr (i32 {STATUS} to ptr)
          ret void
        }}
        """


@_intrinsic  # type: ignore[untyped-decorator, unused-ignore]
def further(context: Any, address: Any, count: Any) -> Any:
    """The address `count` values after `address`."""

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.gep(args[0], [args[1]])

    return address(address, count), generate


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile `function` into the exports that call it; unlike `inner_kernel`, it may make arrays
    of addresses."""
    compiled: Callable[..., Any] = _njit(no_cpython_wrapper=True, **RULES)(function)
    return compiled


def compile_module(exports: Mapping[str, Export], *, simd: bool = False) -> bytes:
    """A WebAssembly module with these functions.

    It imports its memory, of which LLVM's stack is the part below the global that it imports too.
    RuntimeError unless numba was told to leave its code as it is, by NUMBA_OPT=0: once optimized it
    has places in it that were counted for addresses of eight bytes, and here they have four.
    """
    if int(_config.OPT) != 0:
        raise RuntimeError(f"NUMBA_OPT is {int(_config.OPT)}: it must be 0, for code that can move")
    _llvm.initialize_all_targets()
    _llvm.initialize_all_asmprinters()
    features = f"{FEATURES},{SIMD}" if simd else FEATURES
    machine = _llvm.Target.from_triple(TRIPLE).create_target_machine(opt=3, features=features)
    module = _llvm.parse_assembly(_header(machine) + _SURROUNDINGS)
    for name, export in exports.items():
        native, code = _compiled(export)
        code_of_one = _parsed(code, machine)
        entry = export.entry(name, code_of_one.get_function(native))
        _merge_with_others(code_of_one)
        module.link_in(_parsed(entry, machine))  # first: what nobody asks for is left out
        module.link_in(code_of_one)
    _keep_inside(module, but=tuple(exports))
    _optimize(module, machine, simd)
    return with_exports(machine.emit_object(module), tuple(exports))


def _compiled(export: Export) -> tuple[str, str]:
    """Name and LLVM code of a function as numba compiles it, with all that it calls."""
    compiled = _njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **RULES)(export.function)
    compiled.compile(export.takes)
    (made,) = compiled.overloads.values()
    return made.fndesc.llvm_func_name, compiled.inspect_llvm(export.takes)


_OF_THE_MACHINE = re.compile(r'"(target-cpu|target-features|tune-cpu)"="[^"]*"')
_HEADER = re.compile(r"^(target (triple|datalayout)|source_filename) = .*$", re.MULTILINE)
_ERROR = re.compile(r'ptr @"?\.const\.picklebuf\.[^ ,]+')  # what an exception says
_WIDE_PRODUCT = "@llvm.smul.with.overflow.i64"  # of 128 bits, which WebAssembly does not have
_COUNTING = re.compile(
    r"^define [^\n]*@(NRT_incref|NRT_decref)\([^\n]*\{\n.*?^\}$", re.MULTILINE | re.DOTALL
)


def _parsed(code: str, machine: Any) -> Any:
    """A module of LLVM code that was written for another machine."""
    code = _COUNTING.sub(r"declare void @\1(ptr)", code)
    code = _ERROR.sub("ptr null", code).replace(_WIDE_PRODUCT, "@product_of_sizes")
    code = _OF_THE_MACHINE.sub("", _HEADER.sub("", code)).replace(" common ", " internal ")
    module = _llvm.parse_assembly(_header(machine) + code)
    module.verify()
    return module


def _header(machine: Any) -> str:
    return f'target triple = "{TRIPLE}"\ntarget datalayout = "{machine.target_data}"\n'


def _merge_with_others(module: Any) -> None:
    """What another module has too is to be there once; numba gives each function its own name."""
    for each in module.functions:
        if not each.is_declaration and each.linkage.name != "internal":
            each.linkage = "linkonce_odr"


def _keep_inside(module: Any, *, but: str | tuple[str, ...]) -> None:
    """Nothing but some functions is to be known outside of the module."""
    kept = (but,) if isinstance(but, str) else but
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name not in kept:
            each.linkage = "internal"


def _optimize(module: Any, machine: Any, simd: bool) -> None:
    options = _llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = simd
    builder = _llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
