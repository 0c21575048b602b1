"""How one robot decides and drives, from what it knows. This room never sees the world."""
