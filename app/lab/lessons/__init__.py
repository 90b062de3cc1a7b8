"""Lessons in the lab: TOML that Python checks and computes for, and a card in the browser that asks and reveals."""
