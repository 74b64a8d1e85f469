"""The part of a run's page that says how far its reward model can be trusted."""

from __future__ import annotations

from collections.abc import Sequence

from tril.analysis.extrapolation import JudgedGames
from tril.analysis.reward_alarm import RewardAlarm

EXTRAPOLATION = "extrapolation.png"
QUANTITY = "targets hit, less strays"


def extrapolation_lines(groups: Sequence[JudgedGames]) -> list[str]:
    """Return the section on predicted return and true quantity, as lines of Markdown.

    Args:
        groups: All games whose predicted return is known; without any there is no section.
    """
    if not groups:
        return []
    return [
        "## Predicted return and what games were worth",
        "",
        f"Worth is {QUANTITY}. Filled marks are the demonstrations that the reward was learned"
        " from, hollow ones the evaluation games, greedy, sampled and sticky. The band is the range"
        " of the demonstrations' worth, the dashed lines that of their predicted returns; beyond"
        " them the reward is extrapolated.",
        "",
        f"![Predicted return against targets hit, less strays]({EXTRAPOLATION})",
        "",
        "| games of | learned from | games | worth | predicted return | Kendall's tau |",
        "|---|---|---:|---:|---:|---:|",
        *(_row(group) for group in groups),
        "",
    ]


def _row(group: JudgedGames) -> str:
    worths = [game.true_quantity for game in group.games]
    returns = [game.predicted_return for game in group.games]
    cells = (
        group.player,
        "yes" if group.demonstrated else "no",
        str(len(group.games)),
        f"{min(worths)} to {max(worths)}",
        f"{min(returns):.1f} to {max(returns):.1f}",
        "all worth the same" if group.tau is None else f"{group.tau:.2f}",
    )
    return f"| {' | '.join(cells)} |"


def warning_lines(text: str) -> list[str]:
    """Return a warning as lines of Markdown; nothing where there is none."""
    return [f"> **Warning.** {text}", ""] if text else []


def alarm_lines(alarm: RewardAlarm | None) -> list[str]:
    """Return the alarm for reward hacking as lines of Markdown; nothing where all is well."""
    return [] if alarm is None else [f"> **Alarm.** {alarm.message}", ""]
