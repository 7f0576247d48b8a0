"""Billiards as in the literature: balls start with a velocity, with or without gravity.

Uses the exact solver's flights and impacts, on open boards and on boards that repeat without end.
Imports drops, for one ball's path, and the exact solver. Start with billiard.py; flow.py moves many
balls.
"""

from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow import Flow, launch
from benchmarks.billiards.one_ball import path

__all__ = ["Billiard", "Flow", "launch", "path"]
