/** Short names for the generated types. */
import type { components } from "./schema";

type Schemas = components["schemas"];

export type Artifact = Schemas["Artifact"];
export type AttentionMap = Schemas["AttentionMap"];
export type Behaviour = Schemas["Behaviour"];
export type BehaviourNew = Schemas["BehaviourNew"];
export type BehaviourUpdate = Schemas["BehaviourUpdate"];
export type ComparisonRow = Schemas["ComparisonRow"];
export type ConfusedTiers = Schemas["ConfusedTiers"];
export type EvaluationGame = Schemas["EvaluationGame"];
export type Game = Schemas["Game"];
export type GameOpinion = Schemas["GameOpinion"];
export type Ghost = Schemas["Ghost"];
export type ImportResult = Schemas["ImportResult"];
export type Interval = Schemas["Interval"];
export type JudgedGames = Schemas["JudgedGames"];
export type Metrics = Schemas["Metrics"];
export type Player = Schemas["Player"];
export type PolicyGamesSummary = Schemas["PolicyGamesSummary"];
export type PolicySummary = Schemas["PolicySummary"];
export type Ranking = Schemas["Ranking"];
export type RankingCheck = Schemas["RankingCheck"];
export type RankingOpinion = Schemas["RankingOpinion"];
export type Recipe = Schemas["Recipe"];
export type Recording = Schemas["Recording"];
export type RecordingCourse = Schemas["RecordingCourse"];
export type RecordingsChange = Schemas["RecordingsChange"];
export type RecordingUpdate = Schemas["RecordingUpdate"];
export type RewardState = Schemas["RewardState"];
export type RewardTrace = Schemas["RewardTrace"];
export type Run = Schemas["Run"];
export type RunNew = Schemas["RunNew"];
export type RunResults = Schemas["RunResults"];
export type RunUpdate = Schemas["RunUpdate"];
export type System = Schemas["System"];
export type Verdict = Schemas["Verdict"];
