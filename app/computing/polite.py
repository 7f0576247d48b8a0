"""Lower the priority of the fork server, and so of all workers it creates, on import.

Only the fork server imports this.
"""

import os
from typing import Final

_POLITE: Final = 10  # niceness: on a busy machine the event loop gets its time first

os.nice(_POLITE)
