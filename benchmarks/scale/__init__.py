"""What a million spectators, 100,000 rooms and 10^12 drops need, by measured unit costs.

`units` measures what no other benchmark does, `recorded` reads what the pages record, `estimates`
multiplies, and `python -m benchmarks.scale` writes docs/scale.md's tables. Begin with `estimates`.
"""
