"""Structure from motion: a point cloud from a list of views, by back ends that are found by name."""
