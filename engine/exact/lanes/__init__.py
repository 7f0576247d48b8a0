"""Many balls side by side, as native code: each stage of a flight for all balls, then the next.

Imports the exact solver. Start with trace.py, which has the loop and hands balls over to the solver
for one ball. lane.py lays out the memory, flight.py opens windows, search.py finds what balls hit
in them, impact.py applies impacts. trial.py tests native code of all this.
"""
