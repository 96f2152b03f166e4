"""``python -m parkproof``: the same as the command ``parkproof``."""

import sys

from parkproof.cli import main

if __name__ == "__main__":
    sys.exit(main())
