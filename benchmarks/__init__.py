"""What `plinko bench` runs: run time against error, stability, and the price of each feature.

One package a question; they share harness/, scenes/ and contestants/, and import the engine and the
server. Optional contestants are imported when they are asked for. Start with suite.py.
"""
