"""Robot plans that meet their deadlines."""
