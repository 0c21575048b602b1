"""What a range finder sees, the safe regions that follow from it, and their frontiers."""
