"""What goes out and comes in: plans as JSON, CSV and text."""
