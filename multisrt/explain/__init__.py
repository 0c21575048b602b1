"""Why robots decided as they did, explained in words from recordings."""
