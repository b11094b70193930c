"""The structure of the source: circular imports and file sizes."""
