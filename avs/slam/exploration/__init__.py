"""Exploration: what is known of the floor, frontiers, candidate poses, paths to them and their scores."""
