"""Parameters of any base model from runs: what they determine, consistent with physics."""
