"""How much of a scene's surface the views of an episode cover, in structure from motion."""
