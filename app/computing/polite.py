"""What the fork server does to itself first: all that it loads and makes leaves others their time.

Imported there alone, for what the import does. A worker that did it for itself began on the event
loop's core, and had it for 4 ms, each time another took the place of one that had been ended.
"""

import os
from typing import Final

from app.ops import cores

_POLITE: Final = 10  # where there are fewer cores than work, the event loop has its time first

os.nice(_POLITE)
cores.leave_one()
cores.wait_as_usual()
