"""The kernels as WebAssembly, the same bytes wherever they run, and what makes these files.

Imports the whole engine, to make them; nothing imports it. engine/jit/machine_code.py runs them.
Start with plays.py, which calls the kernels of each file once; rehearsal.py makes a file of that,
entries.py is what the page's file exports, make.py writes all.
"""
