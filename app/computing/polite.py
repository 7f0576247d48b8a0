"""What the fork server does to itself first: all that it loads and makes leaves others their time.

Imported there alone, for what the import does.
"""

import os
from typing import Final

_POLITE: Final = 10  # where there are fewer cores than work, the event loop has its time first

os.nice(_POLITE)
