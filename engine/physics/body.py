"""The columns of a ball's state, which is a row of numbers."""

T = 0  # s since the start
X = 1  # centre, m
Y = 2
VX = 3  # m/s
VY = 4
THETA = 5  # rad, positive from +x towards +y
OMEGA = 6  # rad/s
SIZE = 7  # columns
