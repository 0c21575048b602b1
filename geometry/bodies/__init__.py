"""Bodies: their outlines, and how far they are from obstacles."""
