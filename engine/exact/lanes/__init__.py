"""Many balls side by side: each stage of flight and impact for all of them before the next one.

Imports the exact solver. Start with trace.py, which has the loop and hands balls over to the solver
for one ball. lane.py says what is kept of each ball, flight.py opens windows, search.py finds what
is hit in them, impact.py is the impact. trial.py tries native code of all this.
"""
