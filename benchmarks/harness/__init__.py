"""What the benchmarks share: clocks, settings, reports, plots. Start with report.py."""
