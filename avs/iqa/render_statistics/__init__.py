"""Statistics of a rendering and of its camera, and a linear regression of the true SSIM on them: a plain baseline."""
