"""Batches too large for one call: divided into blocks, computed here or on a cluster, summed up.

Imports drops and the certified solver. Start with job.py; workers.py says where work is computed.
"""
