"""Fuzzing of mitlplan: several independent voices on random missions, and every reader on what nobody wrote.

A package beside the planner, not a part of it: the planner never imports it, and its oracles import nothing
of the translation and the search (contracts in pyproject.toml). It is installed with the planner, so that
anyone can ask, on the machine where plans are made, whether what was compiled there agrees with brute force.
"""
