"""`python -m flexhex`."""

from flexhex.cli import main

main()
