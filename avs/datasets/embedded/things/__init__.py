"""Things to put into a scene, from a book to a house. Each stands at the origin."""
