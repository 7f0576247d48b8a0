"""Estimates for a million spectators, 100,000 rooms and 10^12 drops, from measured unit costs.

`units` measures the costs that no other benchmark measures; `estimates` multiplies the recorded
costs. Start with `estimates`.
"""
