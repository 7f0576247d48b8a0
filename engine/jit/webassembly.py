"""Kernels as WebAssembly: numba's LLVM code of some functions, made into one module.

LLVM's result is an object file, a module but for the names of what it exports; the last step adds
these.
"""

from collections.abc import Callable, Mapping
from typing import Any

from numba import njit, types
from numba.extending import intrinsic

from engine.jit import llvm_module
from engine.jit.calls import BLOCK, HEAP, STATUS
from engine.jit.kernel_compiler import RULES
from engine.jit.llvm_module import loads, optimized, target_machine
from engine.jit.wasm_sections import with_exports

_njit: Any = njit
_types: Any = types
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


class Export(llvm_module.Export):
    """A function that returns nothing. Types are those above: numbers, and addresses in the
    module's memory."""

    def entry(self, name: str, native: Any) -> str:
        """Code of a function by this name that calls numba's, which has no result and no error."""
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


class Entry(llvm_module.Export):
    """A kernel of any arguments: its function of a module takes nothing, which costs the least.

    In a block there are eight bytes for each number that numba's code takes. Behind it the result
    is left, and numba's code of how it ended at STATUS.
    """

    def entry(self, name: str, native: Any) -> str:
        """Code of a function by this name that calls numba's."""
        kinds = [str(each.type) for each in native.arguments][2:]
        loaded = loads(kinds, lambda i: f"ptr inttoptr (i32 {BLOCK + 8 * i} to ptr)")
        given = "".join(f", {kind} %a{i}" for i, kind in enumerate(kinds))
        result = f"ptr inttoptr (i32 {BLOCK + 8 * len(kinds)} to ptr)"
        return f"""
        declare i32 @"{native.name}"(ptr, ptr{"".join(f", {kind}" for kind in kinds)})
        define void @"{name}"() {{
          %error = alloca ptr{loaded}
          %status = call i32 @"{native.name}"({result}, ptr %error{given})
          store i32 %status, ptr inttoptr (i32 {STATUS} to ptr)
          ret void
        }}
        """


_WIDE_PRODUCT = "@llvm.smul.with.overflow.i64"  # of 128 bits, which WebAssembly does not have


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


def compile_module(exports: Mapping[str, llvm_module.Export], *, simd: bool = False) -> bytes:
    """A WebAssembly module with these functions.

    It imports its memory, of which LLVM's stack is the part below the global that it imports too.
    """
    features = f"{FEATURES},{SIMD}" if simd else FEATURES
    machine = target_machine(TRIPLE, features=features)
    module = optimized(
        exports, machine, _SURROUNDINGS, simd=simd,
        rewritten=lambda code: code.replace(_WIDE_PRODUCT, "@product_of_sizes"),
    )  # fmt: skip
    return with_exports(machine.emit_object(module), tuple(exports))
