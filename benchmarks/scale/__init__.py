"""What a million spectators, 100,000 rooms and 10^12 drops need, by measured unit costs.

`units` measures what no other benchmark does, `estimates` multiplies what is recorded. Begin with
`estimates`.
"""
