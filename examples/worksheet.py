"""A worksheet for a lesson on chance: a histogram, a falling ball, and figures to discuss.

    pip install plinko-sim
    python worksheet.py [folder]

Writes histogram.png, fall.gif and drops.csv, and prints figures and questions.
"""

import csv
import math
import sys
from pathlib import Path

import plinko

FOLDER = Path((sys.argv[1:] or ["."])[0])
FOLDER.mkdir(parents=True, exist_ok=True)
ROWS, DROPS = 12, 2000

board = plinko.Board.triangle(ROWS)
batch = plinko.drop_many(board, DROPS)

(FOLDER / "histogram.png").write_bytes(plinko.histogram_picture(board, batch.histogram))
(FOLDER / "fall.gif").write_bytes(
    plinko.drop_animation(plinko.drop(board, seed=1), "gif", width=400)
)

columns = batch.columns()
with open(FOLDER / "drops.csv", "w", newline="", encoding="utf-8") as file:
    table = csv.writer(file)
    table.writerow(columns)
    table.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))

# If a fair coin sent the ball left or right at each row, the bins would be binomial.
print(f"{DROPS} balls on {ROWS} rows: balls in each bin, and the number that a fair coin gives")
for number, counted in enumerate(batch.histogram):
    coin = DROPS * math.comb(ROWS, number) / 2**ROWS
    print(f"bin {number:2}  {counted:5}  {coin:7.1f}")
mean = float((batch.bin * 1.0).mean())
print(f"mean bin {mean:.2f}, by the coin {ROWS / 2:.2f}")
spread = float(batch.bin.std())
print(f"standard deviation {spread:.2f}, by the coin {math.sqrt(ROWS) / 2:.2f}")
print(f"mean fall {batch.duration.mean():.2f} s with {batch.impact_count.mean():.1f} impacts")
print("1. Why do the numbers differ from the coin's?  2. What changes with 100 or 100,000 balls?")
print("3. Drop two balls 0.001 m apart (x=…). After how many impacts do they differ by 0.1 m?")
