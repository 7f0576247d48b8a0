"""`python -m plinko`, the same as `plinko`."""

import sys

from app.cli import main

sys.exit(main())
