"""A live board that advances in fixed steps: its balls in flight, contacts and landings.

Imports drops and solvers. Start with world.py; the balls are in exact_balls.py or stepped_balls.py.
"""
