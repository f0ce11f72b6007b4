"""Timed automata and the networks they make; nothing here knows of formulas."""
