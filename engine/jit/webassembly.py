"""Compiles kernels to a WebAssembly module, from numba's LLVM code.

LLVM emits an object file, which is a module without exports; the last step adds these.
"""

from collections.abc import Callable, Mapping
from typing import Any

from numba import njit, types
from numba.extending import intrinsic

from plinko.engine.jit import llvm_module
from plinko.engine.jit.calls import BLOCK, HEAP, STATUS
from plinko.engine.jit.kernel_compiler import RULES
from plinko.engine.jit.llvm_module import loads, optimized, target_machine
from plinko.engine.jit.wasm_sections import with_exports

_njit: Any = njit
_types: Any = types
_intrinsic: Any = intrinsic

TRIPLE = "wasm32-unknown-unknown"

FEATURES = "+bulk-memory,+mutable-globals,+nontrapping-fptoint,+sign-ext"
"""Features that all WebAssembly engines have had for years. No threads and no relaxed SIMD, whose
results may differ from machine to machine."""

SIMD = "+simd128"
"""Vectors of two numbers; each result has the same bits as without vectors."""

FLOATS = _types.CPointer(types.float64)
INTS = _types.CPointer(types.int32)
WORDS = _types.CPointer(types.uint32)
LONGS = _types.CPointer(types.int64)
BYTES = _types.CPointer(types.int8)
INT = types.int32
FLOAT = types.float64

_PASSED = {INT: "i32", FLOAT: "double"}  # all others are addresses

# Numba allocates arrays with NRT_MemInfo_alloc_aligned. Here it takes the memory from the address
# stored at HEAP on, grows the module's memory when that is full, and never frees; the caller
# resets HEAP for each call.
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
    """A function without a result. Its types are those above: numbers, and addresses in the
    module's memory."""

    def entry(self, name: str, native: Any) -> str:
        """LLVM code of a function with this name that calls numba's; its status is ignored."""
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
    """A kernel with any arguments, which are read from memory: a call without arguments is fastest.

    The block at BLOCK has eight bytes for each number that numba's code takes. The function writes
    its result after the block, and numba's status code at STATUS.
    """

    def entry(self, name: str, native: Any) -> str:
        """LLVM code of a function with this name that calls numba's."""
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


# Numba multiplies array sizes with this. LLVM would call a 128-bit product for it, which
# WebAssembly lacks; product_of_sizes suffices for sizes below 2^31.
_WIDE_PRODUCT = "@llvm.smul.with.overflow.i64"


@_intrinsic  # type: ignore[untyped-decorator, unused-ignore]
def further(context: Any, address: Any, count: Any) -> Any:
    """The address `count` values after `address`."""

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.gep(args[0], [args[1]])

    return address(address, count), generate


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile `function` into the exports that call it. Unlike an `inner_kernel`, it may turn
    addresses into arrays."""
    compiled: Callable[..., Any] = _njit(no_cpython_wrapper=True, **RULES)(function)
    return compiled


def compile_module(exports: Mapping[str, llvm_module.Export], *, simd: bool = False) -> bytes:
    """A WebAssembly module with these functions.

    It imports its memory, and a global with the address below which LLVM's stack lies.
    """
    features = f"{FEATURES},{SIMD}" if simd else FEATURES
    machine = target_machine(TRIPLE, features=features)
    module = optimized(
        exports, machine, _SURROUNDINGS, simd=simd,
        rewritten=lambda code: code.replace(_WIDE_PRODUCT, "@product_of_sizes"),
    )  # fmt: skip
    return with_exports(machine.emit_object(module), tuple(exports))
