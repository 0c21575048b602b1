"""Why robots decided as they did, in words, from recordings."""
