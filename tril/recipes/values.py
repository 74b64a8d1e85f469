"""What a recipe is made of: names, types and ranges, which with_values checks."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from tril.games.base import MAX_EVALUATION_STARTS

MAX_COUNT = 1_000_000_000
MAX_STEP_NUMBERS = 10_000
MAX_FACTOR = 1_000
"""Squares of rewards that are larger, summed up over a game, leave little of float32's range."""

MAX_ROLLOUT_STEPS = 262_144
"""Of all environments: their observations take 7.4 GB."""


def _split(value: object) -> object:
    """Split text at its commas."""
    return [part for part in value.split(",") if part] if isinstance(value, str) else value


# The descriptions complete the sentence "policy.n_epochs must be ...".
Count = Annotated[
    int, Field(ge=1, le=MAX_COUNT, description=f"a whole number from 1 to {MAX_COUNT:,}")
]
CountOrNone = Annotated[
    int, Field(ge=0, le=MAX_COUNT, description=f"a whole number from 0 to {MAX_COUNT:,}")
]
Positive = Annotated[
    float, Field(gt=0, le=MAX_FACTOR, allow_inf_nan=False, description="a number above 0")
]
NotNegative = Annotated[
    float, Field(ge=0, le=MAX_FACTOR, allow_inf_nan=False, description="a number, at least 0")
]
LearningRate = Annotated[
    float, Field(gt=0, le=1, allow_inf_nan=False, description="a number above 0")
]
Share = Annotated[float, Field(ge=0, le=1, description="a number from 0 to 1")]
Flag = Annotated[bool, Field(description="true or false")]
StepNumbers = Annotated[
    tuple[Count, ...],
    BeforeValidator(_split),
    Field(
        max_length=MAX_STEP_NUMBERS,
        description="whole numbers with commas between, each at least 1, at most"
        f" {MAX_STEP_NUMBERS:,} of them",
    ),
]
StartNumbers = Annotated[
    tuple[Annotated[int, Field(ge=0, lt=MAX_EVALUATION_STARTS)], ...],
    BeforeValidator(_split),
    Field(
        max_length=MAX_EVALUATION_STARTS,
        description=f"numbers from 0 to {MAX_EVALUATION_STARTS - 1} with commas between",
    ),
]
Network = Literal["nature", "small"]
Method = Literal["ppo", "gail"]


@dataclass(frozen=True)
class RewardRecipe:
    """How the reward model is learned from preference pairs (T-REX, Brown et al. 2019).

    Attributes:
        method: "paper" scores each fragment pair on its own, one pair per update (T-REX, section 4
            and its published code); "posterior" infers which aliens are wanted, see
            `wanted_aliens`; only ``updates`` and the folds' values affect it, and
            fragments only how it is checked; "statement" infers which facts of the game's
            vocabulary the order is about, in any game, see `trainer.reward.statements`.
        learning_rate: Adam's learning rate.
        updates: Gradient updates; method "posterior": passes of Gibbs sampling; "statement":
            updates of the network that reads its facts off the screen.
        fragment_pairs: Number of fragment pairs, sampled once, that the updates pass over; 0 is
            ``updates * pairs_per_update``, so that one pass is enough and no pair is used twice.
        pairs_per_update: Batch size, in fragment pairs.
        fragment_min_steps: Shortest fragment, in observations.
        fragment_max_steps: Longest fragment, in observations, capped at the shorter trajectory of
            a pair.
        observation_stride: Only every n-th observation is scored.
        aligned: Whether both fragments of a pair start at the same step. Otherwise the better one
            starts no earlier than the worse one (T-REX), which by itself makes the learned reward
            rise with time.
        folds: Cross-validation folds that measure the held-out accuracy; 0 skips the measurement.
        fold_updates: ``updates`` of each fold's network.
    """

    method: Literal["paper", "posterior", "statement"] = "paper"
    learning_rate: LearningRate = 5e-5
    updates: Count = 30_000
    fragment_pairs: CountOrNone = 6_000
    pairs_per_update: Count = 1
    fragment_min_steps: Count = 50
    fragment_max_steps: Count = 100
    observation_stride: Count = 2
    aligned: Flag = False
    folds: CountOrNone = 3
    fold_updates: Count = 6_000

    @model_validator(mode="after")
    def _check_fragments(self) -> RewardRecipe:
        if self.fragment_min_steps > self.fragment_max_steps:
            raise ValueError("fragment_min_steps must not be more than fragment_max_steps")
        if self.folds == 1:
            raise ValueError("folds must be 0, which skips the measurement, or at least 2")
        return self

    @property
    def pretrained(self) -> bool:
        """Whether only the output is learned, above layers that ship with Tril.

        See trainer.reward.pretraining.
        """
        return self.method == "posterior"

    @property
    def of_fold(self) -> RewardRecipe:
        """How the network of a cross-validation fold is learned."""
        return replace(self, updates=self.fold_updates)


@dataclass(frozen=True)
class PolicyRecipe:
    """How PPO (Schulman et al. 2017) trains the imitator on the learned reward.

    Names and meanings are those of stable-baselines3's PPO where it has the parameter.

    Attributes:
        network: "nature" is stable-baselines3's NatureCNN, "small" has half of its channels and
            features.
        reward: Shape of the reward, see trainer.policy.reward_shaping: "sigmoid" is sigmoid(R(s'))
            (thesis, section 5.1); "level" is R(s') scaled to 0 at the demonstrations' beginnings
            and 1 at the best ones' ends; "difference" is the change of that level; "softplus" is
            log(1 + exp(R(s'))), GAIL's reward where R is the logit of its discriminator.
        death_penalty: Subtracted from the reward of the step in which the player is hit.
        death_forfeit: Share of the level reached that is subtracted there, too. A penalty alone
            costs as much before the first target as after the last one.
        reward_scale: Factor on the reward. The critic's loss grows with its square and shares a
            network with the policy.
        n_envs: Number of environments run in parallel.
        n_steps: Steps per environment and rollout.
        n_minibatches: Minibatches per epoch; the batch size is n_envs * n_steps / n_minibatches.
        n_epochs: Epochs when optimising the surrogate loss.
        learning_rate: Adam's learning rate.
        anneal_lr: Whether the learning rate falls linearly to zero.
        gamma: Discount factor.
        gae_lambda: Trade-off of bias and variance in the generalised advantage estimator.
        clip_range: Clipping of the probability ratio.
        ent_coef: Entropy coefficient of the loss.
        vf_coef: Value function coefficient of the loss.
        max_grad_norm: Maximum norm of the gradient.
        best_share: Which demonstrations count as the best: the first tier, and further whole tiers
            as long as they fit into this share of the ranking.
        demonstration_share: Share of the episodes that begin in a state of the best or perfect
            demonstrations.
        warm_start: Whether the policy starts from the run's clone, or from the imitator of the
            run that it continues, which has to use the same network.
        mixed_start: Whether a warm start from the clone is from a mixture of it with the policy
            that ships with Tril, which has learned to survive; see
            trainer.policy.imitation.best_mixture.
        kl_coef: Initial coefficient of the KL divergence from that policy; it falls linearly to
            zero over the training. Without a warm start there is none.
        freeze_convolutions: Whether the convolutions stay as the start policy has them and only
            the layers above them learn, which takes a fraction of the time. The start policy has
            to know how the game looks: CloningRecipe.freeze_convolutions.
        critic_warm_up_steps: Steps during which only the critic learns.
        snapshot_steps: Steps after which a snapshot of the policy competes for the best one; the
            published snapshots come after 500,000, then every 1,000,000.
        snapshot_episodes: Games from training starts whose mean return decides between snapshots.
        own_starts: Evaluation starts that replace the training starts, see evaluated_on_own_start.
        opening_share: Share of the episodes from a start that begin with an opening, see
            tril.games.space_invaders.openings.
        sticky_action_probability: Probability, at every frame of a training game, that the previous
            action is repeated (Machado et al. 2018, section 5.1).
    """

    network: Network = "nature"
    reward: Literal["sigmoid", "level", "difference", "softplus"] = "sigmoid"
    death_penalty: NotNegative = 0.0
    death_forfeit: Share = 0.0
    reward_scale: Positive = 1.0
    n_envs: Count = 9
    n_steps: Count = 128
    n_minibatches: Count = 4
    n_epochs: Count = 4
    learning_rate: LearningRate = 3e-4
    anneal_lr: Flag = False
    gamma: Share = 0.99
    gae_lambda: Share = 0.95
    clip_range: Positive = 0.2
    ent_coef: NotNegative = 0.01
    vf_coef: NotNegative = 0.5
    max_grad_norm: Positive = 0.5
    best_share: Share = 0.0
    demonstration_share: Share = 0.0
    warm_start: Flag = False
    mixed_start: Flag = False
    kl_coef: NotNegative = 0.0
    freeze_convolutions: Flag = False
    critic_warm_up_steps: CountOrNone = 0
    snapshot_steps: StepNumbers = (500_000, *range(1_000_000, 10_000_001, 1_000_000))
    snapshot_episodes: Count = 12
    own_starts: StartNumbers = ()
    opening_share: Share = 0.0
    sticky_action_probability: Share = 0.0

    @model_validator(mode="after")
    def _check_minibatches(self) -> PolicyRecipe:
        if 2 * self.n_minibatches > self.n_envs * self.n_steps:
            raise ValueError("n_minibatches must not be more than half of n_envs * n_steps")
        if self.n_envs * self.n_steps > MAX_ROLLOUT_STEPS:
            raise ValueError(
                f"n_envs * n_steps must not be more than {MAX_ROLLOUT_STEPS:,}, which is what fits"
                " into memory"
            )
        if self.freeze_convolutions and not self.warm_start:
            raise ValueError(
                "freeze_convolutions=true needs warm_start=true, a policy to begin with: set it, or"
                " freeze_convolutions=false"
            )
        if self.mixed_start and not (self.freeze_convolutions and self.network == "small"):
            raise ValueError(
                "mixed_start=true needs freeze_convolutions=true and the network 'small': set"
                " both, or mixed_start=false"
            )
        if self.mixed_start and self.kl_coef:
            raise ValueError("mixed_start=true needs kl_coef=0: set it, or mixed_start=false")
        return self


@dataclass(frozen=True)
class CloningRecipe:
    """How the clone is learned from perfect, or the best ranked, demonstrations.

    Behavioural cloning (Ross and Bagnell 2010).

    Attributes:
        network: As in PolicyRecipe.
        learning_rate: Adam's learning rate.
        epochs: Maximum number of epochs.
        batch_size: Observations per update.
        validation_share: Share of the demonstrations held out for early stopping; 0 turns it off.
        patience: Epochs without improvement on those after which learning stops.
        pretrained: Whether it begins with the policy that ships with Tril, which has learned to
            survive, see scripts.pretraining.
        freeze_convolutions: Whether the convolutions of that policy stay as they are.
        scale_layers: Whether layers that begin at random are scaled on the demonstrations' screens
            first, see trainer.nn.scaling.
    """

    network: Network = "nature"
    learning_rate: LearningRate = 3e-4
    epochs: Count = 60
    batch_size: Count = 64
    validation_share: Share = 0.17
    patience: Count = 8
    pretrained: Flag = False
    freeze_convolutions: Flag = False
    scale_layers: Flag = False

    @model_validator(mode="after")
    def _check_start(self) -> CloningRecipe:
        if self.pretrained and self.network != "small":
            raise ValueError(
                "a pretrained clone has the network 'small': choose it, or set pretrained=false and"
                " freeze_convolutions=false"
            )
        if self.freeze_convolutions and not self.pretrained:
            raise ValueError(
                "freeze_convolutions=true needs pretrained=true: set it, or"
                " freeze_convolutions=false"
            )
        return self


@dataclass(frozen=True)
class GailRecipe:
    """How GAIL's discriminator is learned (Ho and Ermon 2016); PPO is as PolicyRecipe says.

    Attributes:
        learning_rate: Adam's learning rate.
        updates: Gradient updates after each rollout.
        batch_size: Observations per update from the policy, and as many from the demonstrations.
        weight_decay: L2 penalty.
    """

    learning_rate: LearningRate = 1e-4
    updates: Count = 8
    batch_size: Count = 64
    weight_decay: NotNegative = 1e-4


@dataclass(frozen=True)
class EvaluationRecipe:
    """Which games the trained policies play.

    Attributes:
        start_numbers: Evaluation starts of the headline table.
        further_start_numbers: Further evaluation starts that the means are taken over.
        openings: Whether the games begin with the starts' openings.
    """

    start_numbers: StartNumbers = (0, 1, 2)
    further_start_numbers: StartNumbers = tuple(range(3, 23))
    openings: Flag = False

    @model_validator(mode="after")
    def _check_numbers(self) -> EvaluationRecipe:
        numbers = (*self.start_numbers, *self.further_start_numbers)
        if not self.start_numbers:
            raise ValueError("start_numbers must name a start that the policies are judged from")
        if len(set(numbers)) < len(numbers):
            raise ValueError("start_numbers and further_start_numbers must name no start twice")
        return self


@dataclass(frozen=True)
class Recipe:
    """A complete way of learning.

    Attributes:
        name: A key of RECIPES, or another name.
        summary: One sentence for people.
        default_steps: Training steps of the imitator that the page proposes.
        ordered_steps: The same where targets have an order; 0 for as many.
        ending: Which event ends a training or evaluation game, see tril.play.episode.Ending.
        method: What trains the imitator: "ppo" on the learned reward, "gail" by PPO against a
            discriminator of the perfect demonstrations. Nothing else of a run depends on it.
        reward: The reward model.
        policy: The imitator.
        cloning: The clone.
        evaluation: The evaluation games.
        gail: The discriminator of method "gail".
    """

    name: str
    summary: str
    default_steps: Count
    ending: Literal["hit", "life_counter"] = "hit"
    method: Method = "ppo"
    reward: RewardRecipe = RewardRecipe()
    policy: PolicyRecipe = PolicyRecipe()
    cloning: CloningRecipe = CloningRecipe()
    evaluation: EvaluationRecipe = EvaluationRecipe()
    gail: GailRecipe = GailRecipe()
    ordered_steps: CountOrNone = 0

    @model_validator(mode="after")
    def _check_method(self) -> Recipe:
        if self.method == "gail" and self.policy.mixed_start:
            raise ValueError(
                "method 'gail' does not train on the learned reward, which chooses among mixtures:"
                " set policy.mixed_start=false"
            )
        return self

    def proposed_steps(self, *, ordered: bool) -> int:
        """Return the training steps to propose for a behaviour.

        Args:
            ordered: Whether its targets have an order.
        """
        return (ordered and self.ordered_steps) or self.default_steps

    @property
    def needs_pretrained(self) -> bool:
        """Whether it needs networks that have learned to read the game's screens."""
        return self.reward.pretrained or self.cloning.pretrained or self.policy.mixed_start

    @property
    def warm_up_steps(self) -> int:
        """Steps in which the imitator does not learn yet, because the critic warms up."""
        return self.policy.critic_warm_up_steps

    def to_dict(self) -> dict[str, Any]:
        """Return the recipe as JSON-ready data; ``recipe_from_dict`` gives it back."""
        return asdict(self)
