"""What radiance fields have in common that are rendered along rays: rays, sampling, optimiser, checkpoints."""
