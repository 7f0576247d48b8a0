"""The decorator of every kernel, and the compiled code that runs in a kernel's place.

Imports only constants and errors of the engine. Start with decorator.py, then machine_code.py,
which runs the artifacts; code_cache.py keeps what wasmtime compiles, limits.py ends calls that take
too long. native.py loads libraries of native code. To make these files, llvm_module.py has numba
compile kernels to LLVM code, and webassembly.py and native_code.py translate that.
"""
