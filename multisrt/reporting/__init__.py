"""Reports of results: tables, figures, a page, LaTeX."""
