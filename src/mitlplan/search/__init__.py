"""From a network to its fastest run: the border to the native half, loops, exact times."""
