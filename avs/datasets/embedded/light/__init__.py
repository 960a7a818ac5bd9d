"""Where light comes from, what surfaces pass on, and what a ray brings back."""
