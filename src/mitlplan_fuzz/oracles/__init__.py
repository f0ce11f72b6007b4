"""What the engine is measured with: slow, readable, and sharing nothing with it."""
