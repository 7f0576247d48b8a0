"""The kernels as WebAssembly and native code, committed as files, and the programs that make them.

Imports the whole engine; nothing imports this package. engine/jit/machine_code.py runs the files.
Start with sample_calls.py, which calls the kernels of each file once; record_types.py compiles the
kernels called, libraries.py the native libraries, make.py writes all files.
"""
