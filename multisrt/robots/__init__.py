"""What runs on a robot: explorers, what they know, what they say. Nothing here sees the truth."""
