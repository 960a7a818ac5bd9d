"""What the significance table says beside its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avs.report.collect import Episodes
from avs.report.intervals import CONFIDENCE, Over
from avs.report.published import called
from avs.report.tables.reconstruction_facts import loop_facts, reconstruction
from avs.report.tables.significance_numbers import LEVEL, Needed, Pair, needed_for, usual_deviation
from avs.report.tables.table_notes import count, scenes_and_seeds
from metrics.definitions import Metric
from metrics.significance import MOST_SCENES, AverageRanks

PAPER_DIFFERENCE = 0.63
"""The paper's PSNR of Ours-RepViT minus that of FisherRF, in decibels: means of nine scenes with one run each."""

_MEANING: Mapping[Over, str] = {
    "scenes": "on other scenes of this kind (test over scenes)",
    "seeds": "with other seeds on these very scenes (test over seeds)",
}


def significance_caption(episodes: Episodes, metric: Metric, pairs: Sequence[Pair]) -> list[str]:
    """Return what was compared, and how."""
    return [
        f"Which methods differ in {metric.name} on the data set {called(episodes.dataset)}: "
        f"{', '.join((*scenes_and_seeds(episodes), *loop_facts(episodes)))}.",
        reconstruction(episodes),
        f"Paired differences of {count(len(pairs), 'pair')} of methods, Student's t, all pairs together at {LEVEL:.0%} "
        "by Holm's correction; above and below count the methods that a row is told to be better and worse than, on "
        "other scenes of this kind and on these scenes with other seeds.",
        "Average rank: over scenes, seeds averaged.",
        f"Scenes needed: to tell the row from the best mean, these two alone, at {LEVEL:.0%} with a power of 0.8; in "
        f"brackets with the {CONFIDENCE:.0%} interval of the standard deviation.",
    ]


def differing_pairs(pairs: Sequence[Pair], over: Over, labels: Mapping[str, str], metric: Metric) -> str:
    """Return which pairs differ by one kind of test, the better method first, or why there is no such test."""
    tested = [(pair, pair.tests[over]) for pair in pairs if over in pair.tests]
    if not tested:
        need = "a second scene" if over == "scenes" else "a second seed"
        return f"{_MEANING[over]}: cannot be told, for lack of {need}"
    better: dict[str, list[str]] = {}
    for pair in (pair for pair, test in tested if test.differs):
        first_wins = (pair.difference > 0.0) == bool(metric.higher_is_better)
        winner, loser = (pair.first, pair.second) if first_wins else (pair.second, pair.first)
        better.setdefault(labels[winner], []).append(labels[loser])
    number, all_pairs = sum(map(len, better.values())), count(len(tested), "pair")
    if not number:
        return f"{_MEANING[over]}: none of {all_pairs} can be told apart, which does not make them equal"
    told = "; ".join(f"{winner} better than {', '.join(losers)}" for winner, losers in better.items())
    rest = len(tested) - number
    unknown = f"; the other {rest} cannot be told apart, which does not make them equal" if rest else ""
    return f"{_MEANING[over]}: {number} of {all_pairs} differ, {told}{unknown}"


def rank_notes(ranks: AverageRanks | None) -> list[str]:
    """Return what Friedman's and Nemenyi's tests say, and what they suppose."""
    if ranks is None:
        return []
    if ranks.blocks < 2:
        return ["average ranks of one scene are its order alone: no test of them"]
    reach = max(ranks.ranks) - min(ranks.ranks)
    verdict = "average ranks differ" if ranks.p_value <= LEVEL else "no difference of average ranks can be told"
    lines = [
        f"Friedman's test over {ranks.blocks} scenes, by permutation: p = {ranks.p_value:.2g}, {verdict}; it supposes "
        "scenes drawn independently of one another, and looks at the order in each of them alone"
    ]
    told = "the farthest apart are" if reach >= ranks.critical else "no two are that far apart; the farthest are"
    lines.append(
        f"Nemenyi's critical difference of average ranks: {ranks.critical:.2f}, too cautious for few scenes; "
        f"{told} {reach:.2f} apart"
    )
    return lines


def power_notes(pairs: Sequence[Pair], metric: Metric) -> list[str]:
    """Return how many scenes a difference as large as the paper's would take."""
    deviation = usual_deviation(pairs)
    if deviation is None or metric.identifier != "psnr":
        return []
    scenes = max(pair.scenes for pair in pairs)
    seeds = sorted({pair.seeds for pair in pairs})
    told = count(seeds[0], "seed") if len(seeds) == 1 else f"{seeds[0]} to {seeds[-1]} seeds"
    needed = needed_for(PAPER_DIFFERENCE, deviation, scenes)
    return [
        f"two methods' difference deviates by {deviation:.2f} {metric.unit} between scenes with {told} each, "
        f"the median over pairs; to tell {PAPER_DIFFERENCE} {metric.unit} from zero, the paper's difference of "
        f"Ours-RepViT to FisherRF over nine scenes with one run each, would take {told_scenes(needed)} scenes"
    ]


def told_scenes(needed: Needed) -> str:
    """Return ``12 (4 to more than 1000)``."""
    words = [
        f"more than {MOST_SCENES}" if each is None else str(each) for each in (needed.scenes, needed.low, needed.high)
    ]
    if words[1] == words[2]:
        return words[0]
    return f"{words[0]} ({words[1]} to {words[2]})"
