import numpy as np
import pytest
import torch
from torch import Tensor

from trainer.reward.pretraining import pretrained_network
from trainer.reward.unhit_aliens import UnhitAliens
from tril.game.space_invaders import COLUMNS, ROWS

N_ALIENS = ROWS * COLUMNS
HIT = {0, 6, 12}
UNHIT = [alien for alien in range(N_ALIENS) if alien not in HIT]


def demonstration(*hits: int) -> Tensor:
    """Return what is read off ten screens per hit: the aliens left, certain, and sweeps unset."""
    states = torch.ones(10 * (1 + len(hits)), 66)
    for number, alien in enumerate(hits):
        states[10 * (1 + number) :, alien] = 0.01
    return states


def test_hitting_one_of_them_is_learned_to_be_worse_and_the_others_stay() -> None:
    network = pretrained_network(np.random.default_rng(0))
    unhit = UnhitAliens(network, [demonstration(0, 6), demonstration(0, 12)], UNHIT)
    with torch.no_grad():
        network.output.weight.zero_()
    optimizer = torch.optim.Adam(network.output.parameters(), lr=0.01)
    rng = np.random.default_rng(1)
    for _ in range(60):
        logits = unhit.logits(64, 5, rng)
        loss = torch.nn.functional.softplus(-logits).mean()
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()

    def reward(*gone: int) -> float:
        aliens = torch.ones(1, N_ALIENS)
        aliens[0, list(gone)] = 0.0
        with torch.no_grad():
            return float(network.from_features(network.features_of(aliens)))

    for alien in range(N_ALIENS):
        change = reward(alien) - reward()
        if alien in HIT:
            assert change == pytest.approx(0.0, abs=0.01)
        else:
            assert change < -0.1


def test_a_logit_is_the_difference_of_a_fragments_rewards() -> None:
    network = pretrained_network(np.random.default_rng(0))
    # All but one alien are hit, so that there is one state to compare.
    unhit = UnhitAliens(network, [demonstration(*range(N_ALIENS - 1))[-1:]], [N_ALIENS - 1])
    left = torch.full((1, N_ALIENS), 0.01)
    left[0, -1] = 1.0
    none_left = left.clone()
    none_left[0, -1] = 0.0
    with torch.no_grad():
        found = unhit.logits(3, 4, np.random.default_rng(0))
        better, worse = (
            network.from_features(network.features_of(one)) for one in (left, none_left)
        )
    torch.testing.assert_close(found, (4 * (better - worse)).expand(3))
