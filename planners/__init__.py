"""How one robot decides and drives, from its own knowledge; nothing here sees the true world."""
