"""Many balls side by side: each stage of flight and impact for all balls before the next stage.

Imports the exact solver. Start with trace.py, which has the loop and hands balls over to the solver
for one ball. lane.py lays out the memory, flight.py opens windows, search.py finds what balls hit
in them, impact.py applies impacts. trial.py tests native code of all this.
"""
