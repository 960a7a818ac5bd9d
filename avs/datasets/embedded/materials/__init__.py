"""Colours and textures of surfaces, made of photographs and noise."""
