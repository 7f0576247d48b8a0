"""The one decorator of every kernel, and the machine code that runs in a kernel's place.

Imports of the engine only constants and errors. Start with decorator.py, then machine_code.py,
which runs the artifacts; limits.py ends calls that take too long. accelerator.py lets long
computations go on with numba's code. webassembly.py makes the artifacts, and with
kernel_compiler.py it alone asks numba to compile.
"""
