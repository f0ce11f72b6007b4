"""The construction of Zhou, Maity and Baras: as they published it, and repaired."""
