"""The same bits as golden.json lists, on whatever processor the tests run."""

import pytest

from tests.golden.stages import digests, expected, jobs_are_comparable, reason_not_to_compare


def test_every_stage_ends_in_the_known_bits(tmp_path):
    reason = reason_not_to_compare()
    if reason:
        pytest.skip(reason)
    known = expected()
    for stage, digest in digests(tmp_path, libraries_alone=not jobs_are_comparable()):
        assert digest == known[stage], f"{stage} is the first stage that differs; see docs/numerics.md"
