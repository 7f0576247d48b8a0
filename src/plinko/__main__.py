"""`python -m plinko`, the same as `plinko`."""

import sys

from plinko.app.cli import main

sys.exit(main())
