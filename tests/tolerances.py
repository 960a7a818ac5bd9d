"""Every tolerance of a numeric comparison in the tests, with its reason."""

# metrics/image.py: everything is float64; the greatest SSIM error comes from the cancellation in a variance near 0,
# about 1e-16 / C2, over a few hundred operations.
SSIM_FLOAT64 = 1e-11
PSNR_FLOAT64 = 1e-10
# The division by 255 happens at different places: a few roundings.
UINT8_EQUALS_FLOAT = 1e-12
# One image is rounded to float32 (6e-8); relative to an SSIM or PSNR of order one, with room for flat windows.
FLOAT32_INPUT = 1e-4
