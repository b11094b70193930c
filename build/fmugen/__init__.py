VERSION = "0.1.0"
"""Of flexhex, as in pyproject.toml; what is built does not depend on what is installed."""
