"""How a table is printed: csv, Markdown, LaTeX."""
