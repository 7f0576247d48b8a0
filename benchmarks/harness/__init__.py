"""What the benchmarks share: clocks, settings, reports, plots.

Imports accuracy's names of columns for the README, and nothing else. Start with report.py.
"""
