"""Buildings as triangle meshes, and what a camera sees in them."""
