"""Tables and figures from episode records."""
