"""Compiles kernels to native code for a named processor, from the same LLVM code as WebAssembly.

The assembly listing is searched for instructions that would change bits: a fused multiply-add
rounds once where other machines round twice.
"""

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from plinko.engine.jit.llvm_module import Export, loads, optimized, target_machine

FUSED = re.compile(r"^\s*(vfn?m(?:add|sub)\w*|fn?m(?:add|sub)\w*|fml[as]\w*)\s", re.MULTILINE)
"""Fused multiply-add instructions of x86-64 and of aarch64."""


class Processor(NamedTuple):
    """A kind of processor, in LLVM's names."""

    triple: str
    cpu: str
    features: str = ""


class NativeEntry(Export):
    """A kernel without a result; its function takes the address of a block and returns a status.

    The block has eight bytes for each number that numba's code takes, as in WebAssembly.
    """

    def entry(self, name: str, native: Any) -> str:
        """LLVM code of a function with this name that calls numba's."""
        kinds = [str(each.type) for each in native.arguments][2:]
        places = "".join(
            f"\n%p{i} = getelementptr i64, ptr %block, i64 {i}" for i in range(len(kinds))
        )
        given = "".join(f", {kind} %a{i}" for i, kind in enumerate(kinds))
        return f"""
        declare i32 @"{native.name}"(ptr, ptr{"".join(f", {kind}" for kind in kinds)})
        define i32 @"{name}"(ptr %block) {{
          %result = alloca ptr
          %error = alloca ptr{places}{loads(kinds, lambda i: f"ptr %p{i}")}
          %status = call i32 @"{native.name}"(ptr %result, ptr %error{given})
          ret i32 %status
        }}
        """


def compile_object(exports: Mapping[str, NativeEntry], processor: Processor) -> bytes:
    """An object file with these functions. Raises ValueError for fused multiply-adds."""
    machine = target_machine(
        processor.triple, cpu=processor.cpu, features=processor.features, reloc="pic",
        codemodel="default",
    )  # fmt: skip
    module = optimized(exports, machine, "", simd=True)
    check_listing(machine.emit_assembly(module))
    code: bytes = machine.emit_object(module)
    return code


def check_listing(listing: str) -> None:
    """Raise ValueError if an assembly listing has a fused instruction."""
    fused = FUSED.search(listing)
    if fused is not None:
        raise ValueError(f"the code fuses: {fused.group(1)}")
