"""What the benchmarks share: clocks, how thorough a run is, reports, plots.

Imports accuracy's names of columns for the README, and nothing else. Start with report.py.
"""
