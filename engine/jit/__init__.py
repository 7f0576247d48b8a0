"""The one decorator of every kernel, and the machine code that runs in a kernel's place.

Imports of the engine only constants. Start with decorator.py, then machine_code.py, which runs the
artifacts. accelerator.py lets long computations go on with numba's code. webassembly.py makes the
artifacts, and with kernel_compiler.py it alone asks numba to compile.
"""
