"""How well networks, metrics and plain numbers predict the SSIM of renderings of scenes that trained none of them."""
