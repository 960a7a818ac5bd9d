"""Metrics as pure functions: no input or output, and nothing imported from ``avs``."""
