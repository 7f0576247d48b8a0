"""Compiles kernels to a WebAssembly module, from numba's LLVM code.

LLVM emits an object file, which is a module without exports; the last step adds these.
"""

from collections.abc import Mapping
from typing import Any

from plinko.engine.jit.calls import BLOCK, HEAP, STATUS
from plinko.engine.jit.llvm_module import Export, loads, optimized, target_machine
from plinko.engine.jit.wasm_sections import with_exports

TRIPLE = "wasm32-unknown-unknown"

FEATURES = "+bulk-memory,+mutable-globals,+nontrapping-fptoint,+sign-ext"
"""Features that all WebAssembly engines have had for years. No threads and no relaxed SIMD, whose
results may differ from machine to machine; and no vectors, from which only lanes would profit."""

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


class Entry(Export):
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


def compile_module(exports: Mapping[str, Entry]) -> bytes:
    """A WebAssembly module with these functions.

    It imports its memory, and a global with the address below which LLVM's stack lies.
    """
    machine = target_machine(TRIPLE, features=FEATURES)
    module = optimized(
        exports, machine, _SURROUNDINGS, simd=False,
        rewritten=lambda code: code.replace(_WIDE_PRODUCT, "@product_of_sizes"),
    )  # fmt: skip
    return with_exports(machine.emit_object(module), tuple(exports))
