/** The pages. Each is loaded on demand; `preloads.json` says which the server has loaded first. */
import { onDemand } from "@/lib/on-demand";

export const HomePage = onDemand(
  async () => (await import("@/features/behaviours/HomePage")).HomePage,
);
export const PlayPage = onDemand(async () => (await import("@/features/play/PlayPage")).PlayPage);
export const RecordingsPage = onDemand(
  async () => (await import("@/features/recordings/RecordingsPage")).RecordingsPage,
);
export const RecordingPage = onDemand(
  async () => (await import("@/features/recordings/RecordingPage")).RecordingPage,
);
export const RankPage = onDemand(
  async () => (await import("@/features/ranking/RankPage")).RankPage,
);
export const TrainPage = onDemand(
  async () => (await import("@/features/training/TrainPage")).TrainPage,
);
export const RunsPage = onDemand(
  async () => (await import("@/features/results/RunsPage")).RunsPage,
);
export const ComparePage = onDemand(
  async () => (await import("@/features/results/compare/ComparePage")).ComparePage,
);
export const RunPage = onDemand(async () => (await import("@/features/results/RunPage")).RunPage);
export const PeoplePage = onDemand(
  async () => (await import("@/features/people/PeoplePage")).PeoplePage,
);
export const GamesPage = onDemand(
  async () => (await import("@/features/behaviours/games/GamesPage")).GamesPage,
);
export const GamePage = onDemand(
  async () => (await import("@/features/behaviours/games/GamePage")).GamePage,
);
export const WatchPage = onDemand(
  async () => (await import("@/features/play/watch/WatchPage")).WatchPage,
);
