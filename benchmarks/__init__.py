"""What `plinko bench` runs: run time against error, stability, and the price of each feature.

One module a question; all of them share the machine's description, the interleaved clock and the
printed tables. Optional contestants are imported when they are asked for.
"""
