r"""Whether a reward's standard deviation is larger where it orders unseen games wrongly.

    python -m benchmarks.learning.uncertainty [column-2:2 column-4:2]

Rewards are learned and checked as in benchmarks.learning.generalisation, from games like a
person's and varied play, and judge unseen games of the same two kinds: pairs of which one is worth
more, by the levels that they end at. Prints for each kind the share of pairs in the wrong order;
the mean standard deviation of wrongly over that of rightly ordered pairs; the area under the ROC
curve of telling wrong pairs by it; and the share in the right order of pairs whose levels are less
than one, one to two, and more than two standard deviations of their difference apart.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
import numpy.typing as npt
import torch

from benchmarks.learning.people import Lesson, Ranked, arguments_of
from trainer.progress import NullProgress
from trainer.reward.check import check_ranking
from trainer.reward.model import RewardModel
from trainer.reward.pretraining import read_features
from trainer.reward.reward_trainer import train_reward_model
from tril.recording import LEVEL_STEPS

Floats = npt.NDArray[np.float64]


def judged(model: RewardModel, games: Ranked) -> dict[str, float]:
    """Return the figures of unseen games of one kind."""
    assert model.spread is not None
    scale = model.one - model.zero
    ends = [one.observations[-LEVEL_STEPS:] for one in games.trajectories]
    features = torch.stack([read_features(one).mean(0) for one in ends])
    levels = np.array([model.level(model.score(one)).mean() for one in ends], np.float64)
    deviations = np.array([_deviation(model, one) for one in ends]) / scale
    merits = games.merits
    pairs = [(i, j) for i, a in enumerate(merits) for j, b in enumerate(merits) if a > b]
    better, worse = np.array(pairs).T
    apart = levels[better] - levels[worse]
    wrong = apart <= 0
    # The deviation of a difference has no constant part.
    between = (features[better] - features[worse]) @ model.spread.weight.T
    ratio = np.abs(apart) / (between.norm(dim=1).double().numpy() / scale)
    of_pair = (deviations[better] + deviations[worse]) / 2
    bins = {"<1": ratio < 1, "1-2": (ratio >= 1) & (ratio < 2), ">2": ratio >= 2}
    return {
        "wrong": float(wrong.mean()),
        "deviation": float(deviations.mean()),
        "wrong/right": float(of_pair[wrong].mean() / of_pair[~wrong].mean()),
        "roc": _area(of_pair[wrong], of_pair[~wrong]),
        **{f"right {name}": float((~wrong)[chosen].mean()) for name, chosen in bins.items()},
    }


def _deviation(model: RewardModel, observations: npt.NDArray[np.uint8]) -> float:
    found = model.judge(observations).deviations
    assert found is not None
    return float(found.mean())


def _area(positive: Floats, negative: Floats) -> float:
    """Return the probability that one of the first is larger than one of the others."""
    return float((positive[:, None] > negative[None, :]).mean())


def main() -> None:
    """Learn and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "cells", nargs="*", default=["column-2:2", "column-4:2"], metavar="BEHAVIOUR:SEED"
    )
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    results: dict[str, list[dict[str, float]]] = {}
    for cell in arguments.cells:
        behaviour, seed = cell.rsplit(":", 1)
        lesson = Lesson(arguments_of(["-b", behaviour, "-s", seed, "--varied-games", "24"]))
        dataset = lesson.dataset()
        model = train_reward_model(dataset, int(seed), NullProgress())
        _, model = check_ranking(model, dataset, int(seed), NullProgress())
        for kind, games in lesson.unseen.kinds.items():
            results.setdefault(kind, []).append(judged(model, games))
            _print(f"{cell} {kind}", results[kind][-1])
    for kind, found in results.items():
        _print(f"mean {kind}", {key: float(np.mean([f[key] for f in found])) for key in found[0]})


def _print(title: str, figures: dict[str, float]) -> None:
    line = " ".join(f"{name} {value:.3f}" for name, value in figures.items())
    sys.stdout.write(f"{title}: {line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
