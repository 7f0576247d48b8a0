"""The state of a ball in flight or in contact: a row of numbers, and what each column is."""

T = 0  # s since the start
X = 1  # centre, m
Y = 2
VX = 3  # m/s
VY = 4
THETA = 5  # rad, positive from +x towards +y
OMEGA = 6  # rad/s
SIZE = 7  # columns
