/** Short names for the generated types. */
import type { components } from "./schema";

type Schemas = components["schemas"];

export type Artifact = Schemas["Artifact"];
export type AuditEntry = Schemas["AuditEntry"];
export type AttentionMap = Schemas["AttentionMap"];
export type Behaviour = Schemas["Behaviour"];
export type BehaviourNew = Schemas["BehaviourNew"];
export type BehaviourUpdate = Schemas["BehaviourUpdate"];
export type BlindAnswer = Schemas["BlindAnswer"];
export type BlindComparison = Schemas["BlindComparison"];
export type BlindResult = Schemas["BlindResult"];
export type ComparisonRow = Schemas["ComparisonRow"];
export type ConfusedTiers = Schemas["ConfusedTiers"];
export type EvaluationGame = Schemas["EvaluationGame"];
export type FinishedBlindRound = Schemas["FinishedBlindRound"];
export type Game = Schemas["Game"];
export type GameOpinion = Schemas["GameOpinion"];
export type Ghost = Schemas["Ghost"];
export type ImportResult = Schemas["ImportResult"];
export type Interval = Schemas["Interval"];
export type Invitation = Schemas["Invitation"];
export type InvitationNew = Schemas["InvitationNew"];
export type JudgedGames = Schemas["JudgedGames"];
export type KeyNew = Schemas["KeyNew"];
export type Library = Schemas["Library"];
export type LibraryColumns = Schemas["LibraryColumns"];
export type Measure = BehaviourNew["measures"] extends readonly (infer One)[] | undefined
  ? One
  : never;
export type MeasuredValue = Schemas["MeasuredValue"];
export type MeasureMean = Schemas["MeasureMean"];
export type MeasureRow = Schemas["MeasureRow"];
export type Metrics = Schemas["Metrics"];
export type NewInvitation = Schemas["NewInvitation"];
export type NewKey = Schemas["NewKey"];
export type Person = Schemas["Person"];
export type SignedInBrowser = Schemas["Browser"];
export type Player = Schemas["Player"];
export type PolicyGamesSummary = Schemas["PolicyGamesSummary"];
export type PolicySummary = Schemas["PolicySummary"];
export type Ranking = Schemas["Ranking"];
export type RankingCheck = Schemas["RankingCheck"];
/** What a reward model infers to be wanted: a label for each item of the grid. */
export type WantedItems = NonNullable<Schemas["RankingCheck"]["wanted"]>;
export type RankingOpinion = Schemas["RankingOpinion"];
export type ReadyMade = Schemas["ReadyMade"];
export type Recipe = Schemas["Recipe"];
export type Recording = Schemas["Recording"];
/** A recording in brief: what lists count, filter and sort by. */
export type LibraryEntry = Pick<
  Recording,
  | "id"
  | "number"
  | "borrowed"
  | "source"
  | "player"
  | "run_id"
  | "parent"
  | "state"
  | "verification"
  | "n_frames"
  | "n_steps"
  | "end"
  | "targets"
  | "strays"
  | "order_errors"
  | "counters"
  | "score"
  | "perfect"
  | "ranked"
  | "deleted"
> & {
  readonly hits: { readonly length: number };
  /** Of a borrowed one; null for the behaviour's own. */
  readonly behaviour_name: string | null;
};
export type RecordingCourse = Schemas["RecordingCourse"];
export type RecordingsChange = Schemas["RecordingsChange"];
export type RoleUpdate = Schemas["RoleUpdate"];
export type RecordingUpdate = Schemas["RecordingUpdate"];
export type Faithfulness = Schemas["Faithfulness"];
export type RewardState = Schemas["RewardState"];
export type RewardTrace = Schemas["RewardTrace"];
export type RevealedPair = Schemas["RevealedPair"];
export type Run = Schemas["Run"];
export type RunNew = Schemas["RunNew"];
export type StatementAnswer = Schemas["StatementAnswer"];
export type Meaning = Schemas["Meaning"];
export type NamedThing = Schemas["NamedThing"];
export type NamedThings = Schemas["NamedThings"];
export type ThingInSight = Schemas["ThingInSight"];
export type ShownMoment = Schemas["ShownMoment"];
export type Understanding = Schemas["Understanding"];
export type UnderstoodStatement = Schemas["UnderstoodStatement"];
export type RunResults = Schemas["RunResults"];
export type RunUpdate = Schemas["RunUpdate"];
export type System = Schemas["System"];
export type TaughtGame = Schemas["TaughtGame"];
export type Title = Schemas["Title"];
export type Verdict = Schemas["Verdict"];
