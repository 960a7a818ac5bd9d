"""Triangle meshes: their parts, and rays against them."""
