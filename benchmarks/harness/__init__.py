"""Parts that all benchmarks share: timing, options of a run, reports, plots.

Start with report.py.
"""
