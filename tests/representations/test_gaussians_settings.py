import subprocess
import sys

import pytest
from pydantic import ValidationError

from avs.representations.gaussians.gaussian_settings import Densification, GaussianSettings, LearningRates


def test_defaults_are_those_of_the_paper():
    settings = GaussianSettings()
    rates, densification = settings.learning_rates, settings.densification
    assert (rates.means, rates.means_final, rates.f_dc, rates.f_rest) == (1.6e-4, 1.6e-6, 2.5e-3, 1.25e-4)
    assert (rates.opacities, rates.scales, rates.quats) == (0.05, 5e-3, 1e-3)
    assert (settings.iterations, settings.sh_degree, settings.sh_increase_every) == (30_000, 3, 1000)
    assert (settings.ssim_weight, settings.adam_epsilon, settings.background) == (0.2, 1e-15, (0, 0, 0))
    assert (densification.start, densification.every, densification.until) == (500, 100, 15_000)
    assert (densification.gradient_threshold, densification.split_scale) == (2e-4, 0.01)
    assert (densification.prune_opacity, densification.prune_scale) == (0.005, 0.1)
    assert (densification.opacity_reset_every, densification.max_gaussians) == (3000, None)


@pytest.mark.parametrize("model", [GaussianSettings, Densification, LearningRates])
def test_a_misspelt_field_is_an_error(model):
    with pytest.raises(ValidationError):
        model(itertions=5)


def test_every_field_is_described():
    for model in (GaussianSettings, Densification, LearningRates):
        assert all(field.description for field in model.model_fields.values())


def test_settings_do_not_import_torch():
    code = "import sys, avs.representations.gaussians.gaussian_settings; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
