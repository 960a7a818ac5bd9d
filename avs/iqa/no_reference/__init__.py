"""No-reference image quality metrics of pyiqa, with parameters that are on this machine already.

pyiqa would download what it lacks, and reads it with pickle. Here its networks and functions are fed with files that
have been verified and read as data, so that a metric neither waits for a network nor runs code from outside.
"""
