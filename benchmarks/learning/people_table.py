"""Tables of what `python -m benchmarks.learning.people` has written to a ledger.

    python -m benchmarks.learning.people_table docs/results/people.jsonl --seed 12 --seed 13

Prints one table in Markdown for each way of training (games learned from, changed values, steps
where they are not as many as `fast` proposes) that several behaviours were trained in, a row a
behaviour, of the trainings that began with today's pretrained weights. Intervals are 95% bootstrap
intervals over trainings and games; the last row has interquartile means over behaviours with
stratified intervals (Agarwal et al. 2021). Then a row for each training, by behaviour, and the taus
of what the check of the ranking said and of how well the reward orders unseen games with the
targets hit, over the trainings whose reward is learned from a ranking, and the check's held-out
accuracy on rankings and on games in a random order.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.learning.own_behaviours import BEHAVIOURS
from trainer.reporting.digests import weights_digest
from tril.analysis.summary import Interval, interquartile_interval, nested_interval
from tril.ranking import kendall_tau
from tril.recipes import FAST

Line = dict[str, Any]

CONDITION = (
    "demonstrations",
    "attempts",
    "ranked_games",
    "best_efforts",
    "varied_games",
    "unsorted",
    "bulk_answers",
    "ranked_alone",
    "reward",
    "rounds_asked",
    "answers",
    "length",
    "set",
    "digest",
    "inference",
)
"""What trainings of one table share."""

SEVERAL = 4
"""Behaviours that a way of training has a table of its own from."""

REWARD_NAMES = {"hits": "reward fitted to the true hits", "shuffled": "in a random order"}

N_SHOWN = 12
"""Games of a person that are ranked, and best efforts, where no fewer were asked for."""

NOT_ASKED = {
    "bulk_answers": 0,
    "ranked_alone": False,
    "attempts": 0,
    "ranked_games": N_SHOWN,
    "best_efforts": N_SHOWN,
    "inference": "",
}
"""What earlier trainings were not asked for."""

GAIL = "method=gail"

FIGURES = ("targets", "strays", "died", "perfect")
HEADINGS = ("targets", "strays", "lost", "perfect games")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ledger", type=Path, nargs="*", default=[Path("docs/results/people.jsonl")])
    parser.add_argument("--weights", default=weights_digest(), help="digest of the weights")
    parser.add_argument("--seed", type=int, action="append", help="of these training seeds alone")
    arguments = parser.parse_args()
    lines = [
        line
        for path in arguments.ledger
        for line in _lines(path, arguments.weights)
        if not arguments.seed or line["training_seed"] in arguments.seed
    ]
    tables: dict[str, list[Line]] = {}
    for line in lines:
        tables.setdefault(json.dumps([line[name] for name in CONDITION]), []).append(line)
    for trainings in tables.values():
        if len({line["behaviour"] for line in trainings}) >= SEVERAL:
            title = f"**{_title(trainings[0])}** (digest {trainings[0]['digest']})"
            sys.stdout.write(f"\n{title}\n\n{table(trainings)}\n")
    sys.stdout.write(f"\n{each(lines)}\n")
    checked = [line for line in lines if "held_out_accuracy" in last_round(line)]
    if by_ranking := [line for line in checked if _learns_from_its_ranking(line)]:
        sys.stdout.write(f"\n{calibration(by_ranking)}\n\n{held_out_accuracies(checked)}\n")


def last_round(line: Line) -> Line:
    """Return the figures of a training's last round."""
    last: Line = line["rounds"][-1]
    return last


def table(trainings: Sequence[Line]) -> str:
    """Return a table in Markdown of trainings that differ in behaviour and seed alone."""
    rows = [
        "| behaviour | seeds | "
        + " | ".join(f"{name}, sticky" for name in HEADINGS)
        + " | targets, greedy | perfect games, greedy | clone: targets, sticky"
        + " | tau, own games | tau, varied games | EPIC distance | minutes |",
        "|---|---|" + "---:|" * (len(HEADINGS) + 7),
    ]
    behaviours = sorted({line["behaviour"] for line in trainings})
    for behaviour in behaviours:
        own = [line for line in trainings if line["behaviour"] == behaviour]
        seeds = ", ".join(str(seed) for seed in sorted(line["training_seed"] for line in own))
        rows.append(_row([behaviour, seeds], own, lambda groups: nested_interval(groups)))
    if len(behaviours) > 1:
        rows.append(_row(["**interquartile mean**", ""], trainings, None))
    return "\n".join(rows)


def each(trainings: Sequence[Line]) -> str:
    """Return a table in Markdown with a row for each training, means over its sticky games."""
    rows = [
        "| behaviour | seed | learned from | targets | strays | lost | perfect games |",
        "|---|---:|---|---:|---:|---:|---:|",
    ]
    for line in sorted(trainings, key=_place):
        found = last_round(line)["sticky"]
        rows.append(
            f"| {line['behaviour']} | {line['training_seed']} | {_title(line)} |"
            f" {found['targets']:.1f} | {found['strays']:.1f} | {found['died']:.0%} |"
            f" {found['perfect']:.0%} |"
        )
    return "\n".join(rows)


def _place(line: Line) -> tuple[str, str, int]:
    """Return what a table of trainings is sorted by."""
    return line["behaviour"], _title(line), line["training_seed"]


def _row(
    names: list[str],
    trainings: Sequence[Line],
    interval_of: Callable[[Sequence[Sequence[float]]], Interval] | None,
) -> str:
    cells = list(names)
    asked = [("sticky", name) for name in FIGURES] + [("greedy", "targets"), ("greedy", "perfect")]
    for how, name in asked:
        if interval_of:
            found = interval_of([_games(last_round(line)[how], name) for line in trainings])
        else:
            found = interquartile_interval(
                [
                    [
                        _games(last_round(line)[how], name)
                        for line in trainings
                        if line["behaviour"] == one
                    ]
                    for one in sorted({line["behaviour"] for line in trainings})
                ]
            )
        cells.append(_formatted(found, as_share=name in ("died", "perfect")))
    cells.append(f"{_mean(line['clone']['targets'] for line in trainings):.1f}")
    for name in ("tau_own", "tau_varied", "epic"):
        cells.append(f"{_mean(last_round(line).get(name, np.nan) for line in trainings):.2f}")
    minutes = [
        sum(one["imitator_s"] + one["reward_s"] for one in t["rounds"]) / 60 for t in trainings
    ]
    cells.append(f"{_mean(minutes):.0f}")
    return f"| {' | '.join(cells)} |"


def calibration(checked: Sequence[Line]) -> str:
    """Return what says beforehand how many targets an imitator will hit, by Kendall's tau."""
    targets = [last_round(line)["sticky"]["targets"] for line in checked]
    names = {
        "held_out_accuracy": "held-out accuracy of the check",
        "tau": "tau of the check",
        "tau_own": "tau on unseen games of the behaviour",
        "tau_varied": "tau on unseen varied games",
    }
    rows = [f"Kendall's tau with the targets hit (sticky), {len(checked)} trainings:", ""]
    order = [[i] for i in np.argsort(targets)[::-1].tolist()]
    for name, heading in names.items():
        values = [last_round(line)[name] for line in checked]
        rows.append(f"- {heading}: {kendall_tau(order, values):.2f}")
    return "\n".join(rows)


def held_out_accuracies(checked: Sequence[Line]) -> str:
    """Return what the check says of rankings, and of games in a random order."""
    rows = []
    for reward, name in (("ranking", "rankings"), ("shuffled", "games in a random order")):
        if found := [last_round(o)["held_out_accuracy"] for o in checked if o["reward"] == reward]:
            rows.append(f"- {name}: {min(found):.0%} to {max(found):.0%} ({len(found)} trainings)")
    return "\n".join(["Held-out accuracy of the check:", "", *rows])


def _learns_from_its_ranking(line: Line) -> bool:
    """Return whether the imitator's reward is that of the ranking that was checked."""
    return line["reward"] == "ranking" and GAIL not in line["set"]


def _lines(path: Path, weights: str) -> list[Line]:
    """Read the trainings with such weights, of those of the same kind and seed the last one."""
    found = {}
    for text in path.read_text(encoding="utf-8").splitlines():
        line = {**NOT_ASKED, **json.loads(text)}
        if line.get("weights") != weights:
            continue
        line |= {"rounds_asked": len(line["rounds"]), "length": _length(line)}
        cell = ("behaviour", "training_seed", *CONDITION)
        found[json.dumps([line[name] for name in cell])] = line
    return list(found.values())


def _length(line: Line) -> str:
    """Return how long a training was, if it was not as long as `fast` proposes."""
    ordered = BEHAVIOURS[line["behaviour"]].ordered
    if line["steps"] == FAST.proposed_steps(ordered=ordered):
        return ""
    return f"{line['steps']:,} steps"


def _games(judged: Line, name: str) -> list[float]:
    return [float(value) for value in judged["games"][name]]


def _formatted(found: Interval, *, as_share: bool) -> str:
    if as_share:
        return f"{found.mean:.0%} [{found.low:.0%}, {found.high:.0%}]"
    return f"{found.mean:.2f} [{found.low:.2f}, {found.high:.2f}]"


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _title(line: Line) -> str:
    varied = f"{line['varied_games'] or 'no'} varied games"
    parts = [f"{n} attempts" if (n := line["attempts"]) else line["demonstrations"]]
    if line["ranked_games"] < N_SHOWN or line["best_efforts"] < N_SHOWN:
        parts.append(f"{line['ranked_games']} ranked games, {line['best_efforts']} best efforts")
    parts.append(varied)
    if line["ranked_alone"]:
        parts.append("no best efforts")
    if line["unsorted"]:
        parts.append("unsorted")
    if line["bulk_answers"]:
        parts.append(f"sorted by {line['bulk_answers']} answers")
    if line["reward"] != "ranking":
        parts.append(REWARD_NAMES[line["reward"]])
    if line["rounds_asked"] > 1:
        n = line["rounds_asked"] - 1
        when = f"each of {n} rounds" if n > 1 else "the first round"
        parts.append(f"{line['answers']} answers after {when}")
    changed = ["by GAIL"] if GAIL in line["set"] else line["set"]
    if line["inference"]:
        changed = [*changed, f"inference {line['inference']}"]
    return ", ".join([*parts, *filter(None, [line["length"]]), *changed])


if __name__ == "__main__":
    main()
