"""Logs of machines simulated in MuJoCo, in which an effect is hidden: see README.md."""
