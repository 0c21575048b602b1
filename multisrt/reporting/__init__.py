"""From results to what people read: tables, figures, a page, LaTeX."""
