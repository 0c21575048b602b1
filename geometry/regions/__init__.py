"""What a range finder sees, and the regions that follow from it."""
