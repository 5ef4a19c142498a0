"""One file a command: its arguments, the files that it writes, and what it does. `cli.py` finds them here."""
