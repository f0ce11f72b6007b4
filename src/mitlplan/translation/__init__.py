"""From formulas to timed automata, by two constructions."""
