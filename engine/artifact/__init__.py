"""The kernels as WebAssembly, the same bytes wherever they run, and what makes these files.

Imports the whole engine, to make them; nothing imports it. engine/jit/machine_code.py runs them.
Start with rehearsal.py, where the kernels of each file are called once; entries.py is what the
page's file exports; make.py writes all.
"""
