"""Active SLAM (Task B2): a robot explores a building; view selectors decide where it goes."""
