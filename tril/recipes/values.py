"""What a recipe is made of."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal, get_args

from tril.errors import Invalid

Method = Literal["ppo", "dagger", "gail"]

MOST_DAGGER_STEPS = 60_000
"""DAgger keeps every observation that it has seen, 28 kB each, and twice while it learns."""


@dataclass(frozen=True)
class RewardRecipe:
    """How the reward model is learned from preference pairs (T-REX, Brown et al. 2019).

    Attributes:
        method: "paper" scores each fragment pair on its own, one pair per update (T-REX, section 4
            and its published code); "fast" scores every demonstration frame once per update and
            builds all fragment sums from prefix sums.
        learning_rate: Adam's step size.
        updates: Gradient updates.
        fragment_pairs: Method "paper": fragment pairs, drawn once and gone through in as many
            passes as the updates make; 0 draws new ones all the time.
        pairs_per_update: Fragment pairs whose loss one update averages.
        fragment_min_steps: Shortest fragment, in observations.
        fragment_max_steps: Longest fragment, in observations, capped at the shorter game of a pair.
        observation_stride: Every how many-th observation is scored.
        aligned: Whether both fragments of a pair start at the same step. Otherwise the better one
            starts no earlier than the worse one (T-REX), which by itself makes the learned reward
            rise with time.
        free_share: Method "fast": share of the ranking's fragment pairs whose starts are drawn
            independently of each other. Pairs that start at the same step leave open how R changes
            with time alone; these don't.
        perfect_share: Method "fast": share of all fragment pairs in which a perfect game is better
            than one below the first tier.
        perturbed_share: Method "fast": share of all fragment pairs in which a perfect game is
            better than a perturbed copy of itself (after D-REX, Brown et al. 2020).
        perturbed_copies: Copies made of each perfect game.
        ensemble: Number of reward models whose standardised outputs are averaged.
        folds: Cross-validation folds of demonstrations left out to measure the held-out accuracy;
            0 leaves the measurement out.
        fold_updates: Gradient updates of each fold's model.
        fold_stride: As observation_stride, for the folds' models; 0 is as the final one's.
        weight_decay: L2 penalty.
    """

    method: Literal["paper", "fast"] = "paper"
    learning_rate: float = 5e-5
    updates: int = 30_000
    fragment_pairs: int = 6_000
    pairs_per_update: int = 1
    fragment_min_steps: int = 50
    fragment_max_steps: int = 100
    observation_stride: int = 2
    aligned: bool = False
    free_share: float = 0.0
    perfect_share: float = 0.0
    perturbed_share: float = 0.0
    perturbed_copies: int = 8
    ensemble: int = 1
    folds: int = 3
    fold_updates: int = 6_000
    fold_stride: int = 0
    weight_decay: float = 0.0

    @property
    def of_a_fold(self) -> RewardRecipe:
        """How the model of a cross-validation fold is learned."""
        stride = self.fold_stride or self.observation_stride
        return replace(self, updates=self.fold_updates, observation_stride=stride)


@dataclass(frozen=True)
class PolicyRecipe:
    """How the imitator is trained by PPO (Schulman et al. 2017) on the learned reward.

    Attributes:
        network: "nature" is the Atari network of stable-baselines3, "small" the same with half of
            the channels and features.
        reward: "sigmoid" pays sigmoid(R(s')) per step (thesis, section 5.1); "level" pays R(s')
            scaled so that the demonstrations' beginnings pay 0 and the best ones' ends 1;
            "difference" pays the change of that level, so that progress pays and waiting doesn't;
            "softplus" pays log(1 + exp(R(s'))), which is GAIL's reward where R is the logit of
            its discriminator.
        death_penalty: Subtracted from the reward of the step in which the player is hit.
        reward_scale: What all this is multiplied by, so that the critic's errors, which grow with
            the rewards' squares, don't drown what the policy learns from.
        n_envs: Games played side by side.
        n_steps: Steps per game between updates.
        n_minibatches: Minibatches per epoch.
        n_epochs: Passes over each rollout.
        learning_rate: Adam's step size.
        anneal_lr: Whether the step size falls linearly to zero.
        gamma: gamma.
        gae_lambda: lambda of generalised advantage estimation.
        clip_range: PPO's clip range.
        ent_coef: Weight of the entropy bonus.
        vf_coef: Weight of the value loss.
        max_grad_norm: Bound of the gradient's norm.
        best_share: Which demonstrations count as the best ones: the first tier, and further whole
            tiers as long as they fit into this share of all ranked ones.
        demonstration_share: Share of episodes begun from states of the best demonstrations and the
            perfect ones.
        warm_start: Whether the policy starts from the run's clone, whose network it then shares.
        kl_coef: Initial weight of the KL divergence from the start policy; falls
            linearly to zero over the training.
        critic_warm_up_steps: Steps in which only the critic learns.
        snapshot_steps: Steps after which the policy is kept for choosing the best one; the first
            of the published work's snapshots comes after 500,000, then every 1,000,000.
        snapshot_episodes: Games from training starts by which a snapshot's mean predicted return
            is judged.
        own_starts: Evaluation starts that take the place of the training starts, see
            judged_where_trained.
    """

    network: Literal["nature", "small"] = "nature"
    reward: Literal["sigmoid", "level", "difference", "softplus"] = "sigmoid"
    death_penalty: float = 0.0
    reward_scale: float = 1.0
    n_envs: int = 9
    n_steps: int = 128
    n_minibatches: int = 4
    n_epochs: int = 4
    learning_rate: float = 3e-4
    anneal_lr: bool = False
    gamma: float = 0.99
    gae_lambda: float = 0.95
    clip_range: float = 0.2
    ent_coef: float = 0.01
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5
    best_share: float = 0.0
    demonstration_share: float = 0.0
    warm_start: bool = False
    kl_coef: float = 0.0
    critic_warm_up_steps: int = 0
    snapshot_steps: tuple[int, ...] = (500_000, *range(1_000_000, 10_000_001, 1_000_000))
    snapshot_episodes: int = 12
    own_starts: tuple[int, ...] = ()


@dataclass(frozen=True)
class CloningRecipe:
    """How the clone is learned from the perfect demonstrations (Ross and Bagnell 2010).

    Attributes:
        network: As in PolicyRecipe.
        learning_rate: Adam's step size.
        epochs: Most passes over the perfect demonstrations.
        batch_size: Observations per update.
        validation_share: Share of the demonstrations left out for early stopping; 0 turns it off.
        patience: Epochs without improvement on those after which learning stops.
    """

    network: Literal["nature", "small"] = "nature"
    learning_rate: float = 3e-4
    epochs: int = 60
    batch_size: int = 64
    validation_share: float = 0.17
    patience: int = 8


@dataclass(frozen=True)
class DaggerRecipe:
    """How the imitator is learned from an expert's corrections (DAgger, Ross et al. 2011).

    The network and its learning rate are those of PolicyRecipe, how it is trained on what has been
    collected is that of CloningRecipe.

    Attributes:
        steps_per_iteration: Steps played and labelled between two trainings of the policy, rounded
            up to whole games.
        expert_decay: p of beta_i = p^(i-1), the probability with which a step of iteration i is
            the expert's; in the first all are (Ross et al. 2011, section 3).
    """

    steps_per_iteration: int = 1_500
    expert_decay: float = 0.5


@dataclass(frozen=True)
class GailRecipe:
    """How GAIL's discriminator is learned (Ho and Ermon 2016); the policy is as PolicyRecipe says.

    Attributes:
        learning_rate: Adam's step size.
        updates: Gradient updates after each rollout.
        batch_size: Observations of the policy in an update, and as many of the demonstrations.
        weight_decay: L2 penalty.
    """

    learning_rate: float = 1e-4
    updates: int = 8
    batch_size: int = 64
    weight_decay: float = 1e-4


@dataclass(frozen=True)
class EvaluationRecipe:
    """Which games the trained policies play.

    Attributes:
        start_numbers: Evaluation starts of the headline table.
        further_start_numbers: Evaluation starts of the means.
    """

    start_numbers: tuple[int, ...] = (0, 1, 2)
    further_start_numbers: tuple[int, ...] = tuple(range(3, 23))


@dataclass(frozen=True)
class Recipe:
    """A complete way of learning.

    Attributes:
        name: One of RECIPES, or a name of its own.
        summary: One sentence for people.
        default_steps: Steps of the imitator's training games offered on the page.
        ending: Which event ends a training or evaluation game, see tril.game.episode.Ending.
        method: What trains the imitator: "ppo" on the learned reward, "dagger" on the corrections
            of the scripted demonstrator, "gail" by PPO against a discriminator of the perfect
            demonstrations. All else of a run is the same.
    """

    name: str
    summary: str
    default_steps: int
    ending: str = "hit"
    method: Method = "ppo"
    reward: RewardRecipe = field(default_factory=RewardRecipe)
    policy: PolicyRecipe = field(default_factory=PolicyRecipe)
    cloning: CloningRecipe = field(default_factory=CloningRecipe)
    evaluation: EvaluationRecipe = field(default_factory=EvaluationRecipe)
    dagger: DaggerRecipe = field(default_factory=DaggerRecipe)
    gail: GailRecipe = field(default_factory=GailRecipe)

    def __post_init__(self) -> None:
        """Check the method.

        Raises:
            Invalid: There is no such method.
        """
        if self.method not in get_args(Method):
            methods = ", ".join(get_args(Method))
            raise Invalid(f"There is no method {self.method!r}; choose one of {methods}.")

    def to_dict(self) -> dict[str, Any]:
        """The recipe as JSON-ready data; ``from_dict`` gives it back."""
        return asdict(self)
