"""The one decorator of every kernel, and the machine code that runs in a kernel's place.

Imports of the engine only constants and errors. Start with decorator.py, then machine_code.py,
which runs the artifacts; in_place.py is of calls that are repeated. code_cache.py keeps what
wasmtime compiles, limits.py ends calls that take too long. native.py loads the libraries of native
code. webassembly.py and native_code.py make both of what llvm_module.py, which with
kernel_compiler.py alone asks numba to compile, makes of kernels.
"""
