import { useQuery } from "@tanstack/react-query";
import type { ReactNode } from "react";
import { createBrowserRouter, Navigate, useParams } from "react-router";

import { ErrorPage } from "./ErrorPage";
import { Layout } from "./Layout";
import { NotFound } from "./NotFound";

import { isNotFound } from "@/api/client";
import { runQuery } from "@/api/runs";
import type { Behaviour } from "@/api/types";
import { Failed, Loading } from "@/components/States";
import { BehaviourFrame } from "@/features/behaviours/BehaviourFrame";
import { HomePage } from "@/features/behaviours/HomePage";
import { PlayPage } from "@/features/play/PlayPage";
import { RankPage } from "@/features/ranking/RankPage";
import { RecordingsPage } from "@/features/recordings/RecordingsPage";
import { RunPage } from "@/features/results/RunPage";
import { RunsPage } from "@/features/results/RunsPage";
import { TrainPage } from "@/features/training/TrainPage";

/** A page of a behaviour, in its frame; a new behaviour is a new page. */
function InBehaviour({ page }: { page: (behaviour: Behaviour) => ReactNode }) {
  const { behaviourId } = useParams();
  const id = Number(behaviourId);
  if (!Number.isInteger(id) || id < 1) return <NotFound />;
  return (
    <BehaviourFrame key={id} behaviourId={id}>
      {page}
    </BehaviourFrame>
  );
}

/** A run's page, in the frame of its behaviour. */
function RunRoute() {
  const { runId = "" } = useParams();
  const { data: run, error, refetch } = useQuery(runQuery(runId));
  if (isNotFound(error)) return <NotFound />;
  if (error && !run) return <Failed what="The run" error={error} onRetry={() => void refetch()} />;
  if (!run) return <Loading what="the run" rows={3} height="6rem" />;
  return (
    <BehaviourFrame behaviourId={run.behaviour_id} looking>
      {(behaviour) => <RunPage key={run.id} run={run} behaviour={behaviour} />}
    </BehaviourFrame>
  );
}

export const routes = [
  {
    path: "/",
    element: <Layout />,
    errorElement: <ErrorPage />,
    children: [
      { index: true, element: <HomePage /> },
      {
        path: "behaviours/:behaviourId",
        children: [
          { index: true, element: <Navigate to="play" replace /> },
          { path: "play", element: <InBehaviour page={playPage} /> },
          { path: "recordings", element: <InBehaviour page={recordingsPage} /> },
          { path: "rank", element: <InBehaviour page={rankPage} /> },
          { path: "train", element: <InBehaviour page={trainPage} /> },
          { path: "runs", element: <InBehaviour page={runsPage} /> },
        ],
      },
      { path: "runs/:runId", element: <RunRoute /> },
      { path: "*", element: <NotFound /> },
    ],
  },
];

function playPage(behaviour: Behaviour): ReactNode {
  return <PlayPage behaviour={behaviour} />;
}

function recordingsPage(behaviour: Behaviour): ReactNode {
  return <RecordingsPage behaviour={behaviour} />;
}

function rankPage(behaviour: Behaviour): ReactNode {
  return <RankPage behaviour={behaviour} />;
}

function trainPage(behaviour: Behaviour): ReactNode {
  return <TrainPage behaviour={behaviour} />;
}

function runsPage(behaviour: Behaviour): ReactNode {
  return <RunsPage behaviour={behaviour} />;
}

export function createRouter() {
  return createBrowserRouter(routes);
}
