"""Which episodes may stand in one table, in whatever order their files are named."""

import itertools

import pytest

from avs.report.collect import common_protocol, read_dataset
from avs.system.errors import UserError

METHODS = ["random", "fisherrf", "farthest"]


def with_loop(episode, method, own=(), **changes):
    """Return an episode with these settings of the loop, of which the method has ``own`` for itself."""
    made = episode(method, own=list(own), seed=changes.pop("seed", 0), scene=changes.pop("scene", "attic"))
    return made.model_copy(update={"protocol": made.protocol | changes})


def faults(written, episodes):
    """Return the faults of all orders of the files, without their paths; None for an order that is accepted."""
    found = set()
    for order in itertools.permutations(written(episodes)):
        try:
            read_dataset(list(order), METHODS, "orbit")
            found.add(None)
        except UserError as error:
            found.add(str(error).partition(": ")[2].partition(":")[0])
    return found


def test_a_method_with_settings_of_its_own_hides_no_difference_between_others(episode, written):
    own = with_loop(episode, "random", ["additions"], additions=[10, 90])
    runs = [own, with_loop(episode, "fisherrf"), with_loop(episode, "farthest", additions=[30, 60])]
    assert faults(written, runs) == {"not comparable with other episodes of orbit, protocol.additions"}
    assert faults(written, [own, with_loop(episode, "fisherrf"), with_loop(episode, "farthest")]) == {None}


def test_what_two_methods_have_for_themselves_is_compared_with_the_others_key_by_key(episode, written):
    first = with_loop(episode, "random", ["additions"], additions=[10, 90])
    second = with_loop(episode, "fisherrf", ["refit"], refit="reinit")
    assert faults(written, [first, second, with_loop(episode, "farthest")]) == {None}
    other = with_loop(episode, "fisherrf", ["refit"], refit="reinit", views_per_step=2)
    found = faults(written, [first, other, with_loop(episode, "farthest")])
    assert found == {"not comparable with other episodes of orbit, protocol.views_per_step"}


@pytest.mark.parametrize("place", [{"seed": 1}, {"scene": "cellar"}])
def test_episodes_of_one_method_have_the_same_settings_for_themselves(episode, written, place):
    own, rest = with_loop(episode, "random", ["additions"], additions=[10, 90]), with_loop(episode, "farthest")
    other = with_loop(episode, "random", ["additions"], additions=[10, 80], **place)
    assert faults(written, [own, other, rest]) == {"not comparable with other episodes of orbit, protocol.additions"}
    usual = with_loop(episode, "random", **place)
    assert faults(written, [own, usual, rest]) == {"not comparable with other episodes of orbit, protocol.additions"}
    same = with_loop(episode, "random", additions=[10, 90], **place)
    assert None not in faults(written, [own, same, rest])
    assert None not in faults(written, [own, same])


def test_episodes_of_one_method_are_in_one_group(episode, written):
    ranked, unranked = episode("random"), episode("random", seed=1, group="Own schedule")
    assert faults(written, [ranked, unranked]) == {"not comparable with other episodes of orbit, group"}


def test_the_settings_of_the_run_are_told_although_each_method_has_one_for_itself(episode, written):
    first = with_loop(episode, "random", ["additions"], additions=[10, 90])
    second = with_loop(episode, "fisherrf", ["refit"], refit="reinit")
    for order in itertools.permutations(written([first, second])):
        told = common_protocol(read_dataset(list(order), METHODS, "orbit"))
        assert (told["additions"], told["refit"]) == ([20, 45], "continue")
