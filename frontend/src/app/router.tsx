import { t } from "@lingui/core/macro";
import { usePrefetchQuery, useQuery } from "@tanstack/react-query";
import { type ComponentType, type ReactNode, Suspense, useEffect } from "react";
import { createBrowserRouter, Navigate, useParams } from "react-router";

import { behaviourQuery } from "@/api/behaviours";
import { isNotFound } from "@/api/client";
import { borrowedQuery, libraryQuery } from "@/api/library";
import { recordingQuery } from "@/api/recordings";
import { resultsQuery, runQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Layout } from "@/app/layout/Layout";
import { Failed, Loading } from "@/components/feedback/States";
import { BehaviourFrame } from "@/features/behaviours/BehaviourFrame";
import { rankingQuery } from "@/features/ranking/order/rankings";
import { useMetricsQuery } from "@/features/results/curves/metrics";

import { ErrorPage } from "./ErrorPage";
import { NotFound } from "./NotFound";
import {
  ComparePage,
  GamePage,
  GamesPage,
  HomePage,
  PeoplePage,
  PlayPage,
  RankPage,
  RecordingPage,
  RecordingsPage,
  RunPage,
  RunsPage,
  TrainPage,
  WatchPage,
} from "./pages";

/** Shows a placeholder while the code of a page loads. */
function Lazy({ children }: { children: ReactNode }) {
  return <Suspense fallback={<Loading what={t`the page`} rows={3} />}>{children}</Suspense>;
}

interface InBehaviourProps {
  page: (behaviour: Behaviour) => ReactNode;
  /** Fetches what the page needs beside the behaviour, not one after the other. */
  beside?: ComponentType<{ behaviourId: number }>;
}

/** A page of a behaviour, in its frame; remounted when the behaviour changes. */
function InBehaviour({ page, beside: Beside }: InBehaviourProps) {
  const { behaviourId } = useParams();
  const id = Number(behaviourId);
  if (!Number.isInteger(id) || id < 1) return <NotFound />;
  return (
    <>
      {Beside && <Beside behaviourId={id} />}
      <BehaviourFrame key={id} behaviourId={id}>
        {(behaviour) => <Lazy>{page(behaviour)}</Lazy>}
      </BehaviourFrame>
    </>
  );
}

function RecordingsBeside({ behaviourId }: { behaviourId: number }) {
  usePrefetchQuery(behaviourQuery(behaviourId));
  usePrefetchQuery(libraryQuery(behaviourId));
  return null;
}

function RankingBeside({ behaviourId }: { behaviourId: number }) {
  usePrefetchQuery(behaviourQuery(behaviourId));
  usePrefetchQuery(rankingQuery(behaviourId));
  usePrefetchQuery(borrowedQuery(behaviourId));
  usePrefetchQuery(libraryQuery(behaviourId));
  useEffect(() => void RankPage.load(), []);
  return null;
}

/** A page of a run, in the frame of its behaviour. */
function RunRoute({ page }: { page: (run: Run, behaviour: Behaviour) => ReactNode }) {
  const { runId = "" } = useParams();
  const { data: run, error, refetch } = useQuery(runQuery(runId));
  if (isNotFound(error)) return <NotFound />;
  if (error && !run)
    return <Failed what={t`The run`} error={error} onRetry={() => void refetch()} />;
  if (!run) return <Loading what={t`the run`} rows={3} height="6rem" />;
  return (
    <BehaviourFrame behaviourId={run.behaviour_id} looking>
      {(behaviour) => <Lazy>{page(run, behaviour)}</Lazy>}
    </BehaviourFrame>
  );
}

/** A run's page; its results, curves and code are fetched beside the run, not one after the other. */
function RunPageRoute() {
  const { runId = "" } = useParams();
  usePrefetchQuery(resultsQuery(runId));
  usePrefetchQuery(useMetricsQuery(runId));
  useEffect(() => void RunPage.load(), []);
  return <RunRoute page={runPage} />;
}

/** A recording's page, in the frame of its behaviour. */
function RecordingRoute() {
  const { recordingId } = useParams();
  const id = Number(recordingId);
  const exists = Number.isInteger(id) && id >= 1;
  const { data, error, refetch } = useQuery({ ...recordingQuery(id), enabled: exists });
  if (!exists || isNotFound(error)) return <NotFound />;
  if (error && !data) {
    return <Failed what={t`The recording`} error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what={t`the recording`} rows={3} height="6rem" />;
  return (
    <BehaviourFrame behaviourId={data.behaviour_id}>
      {(behaviour) => (
        <Lazy>
          <RecordingPage key={data.id} recording={data} behaviour={behaviour} />
        </Lazy>
      )}
    </BehaviourFrame>
  );
}

/** All games, or the one that the rest of the address names. */
function GamesRoute() {
  const name = useParams()["*"] ?? "";
  return name === "" ? <GamesPage /> : <GamePage key={name} name={name} />;
}

export const routes = [
  {
    path: "/",
    element: <Layout />,
    errorElement: <ErrorPage />,
    children: [
      {
        index: true,
        element: (
          <Lazy>
            <HomePage />
          </Lazy>
        ),
      },
      {
        path: "behaviours/:behaviourId",
        children: [
          { index: true, element: <Navigate to="play" replace /> },
          { path: "play", element: <InBehaviour page={playPage} /> },
          {
            path: "recordings",
            element: <InBehaviour page={recordingsPage} beside={RecordingsBeside} />,
          },
          { path: "rank", element: <InBehaviour page={rankPage} beside={RankingBeside} /> },
          { path: "train", element: <InBehaviour page={trainPage} /> },
          { path: "runs", element: <InBehaviour page={runsPage} /> },
        ],
      },
      { path: "recordings/:recordingId", element: <RecordingRoute /> },
      {
        path: "runs/compare",
        element: (
          <Lazy>
            <ComparePage />
          </Lazy>
        ),
      },
      { path: "runs/:runId", element: <RunPageRoute /> },
      { path: "runs/:runId/watch", element: <RunRoute page={watchPage} /> },
      {
        path: "people",
        element: (
          <Lazy>
            <PeoplePage />
          </Lazy>
        ),
      },
      {
        path: "games/*",
        element: (
          <Lazy>
            <GamesRoute />
          </Lazy>
        ),
      },
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

function runPage(run: Run, behaviour: Behaviour): ReactNode {
  return <RunPage key={run.id} run={run} behaviour={behaviour} />;
}

function watchPage(run: Run, behaviour: Behaviour): ReactNode {
  return <WatchPage key={run.id} run={run} behaviour={behaviour} />;
}

export function createRouter() {
  return createBrowserRouter(routes);
}
