"""Formulas, as written and in normal form, and the judge of signals; nothing here knows of automata."""
