VERSION = "0.1.0"
"""Version of flexhex; pyproject.toml and `flexhex.__version__` read it here."""
