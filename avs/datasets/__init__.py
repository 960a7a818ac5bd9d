"""Sources of scenes, one file each."""
