import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { Link } from "react-router";

import { behavioursQuery } from "@/api/behaviours";
import { catalogueQuery } from "@/games/catalogue";
import { runsQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { ActorMark } from "@/components/game/ActorMark";
import { useFirst } from "@/components/list/use-first";
import { PageTitle } from "@/components/PageTitle";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { Tour } from "@/features/behaviours/tour/Tour";
import { bounds, fixed, wholeShare } from "@/lib/format";
import { isActive, statusLine } from "@/lib/runs";

import { ExampleButton } from "./ExampleButton";
import { FinishedExampleButton } from "./FinishedExampleButton";
import { BehaviourMark } from "./GameMark";
import styles from "./HomePage.module.css";
import { NewBehaviourDialog } from "./NewBehaviourDialog";

/** How many behaviours are shown at a time. */
const CARDS = 48;

/** The list of behaviours; until something other than examples was made, an introduction too. */
export function HomePage() {
  const behaviours = useQuery(behavioursQuery);
  const onlyPlays = useOnlyPlays();
  const runs = useQuery({ ...runsQuery(), enabled: onlyPlays === false });
  const { data: games } = useQuery(catalogueQuery);
  const [making, setMaking] = useState(false);
  const [shown, more] = useFirst(ownFirst(behaviours.data ?? []), CARDS);

  if (behaviours.error && !behaviours.data) {
    return (
      <Failed
        what={t`The behaviours`}
        error={behaviours.error}
        onRetry={() => void behaviours.refetch()}
      />
    );
  }
  if (!behaviours.data || (runs.isLoading && behaviours.data.some(({ n_runs: n }) => n > 0)))
    return <Loading what={t`the behaviours`} rows={4} height="6rem" />;
  const all = behaviours.data;
  const isOneGame = all.every(({ game }) => game === all[0]?.game);
  const isNew = !onlyPlays && all.every((one) => isUntouched(one, runs.data));
  return (
    <>
      <PageTitle>Tril</PageTitle>
      {isNew && <Welcome all={all} />}
      {!onlyPlays && <Tour isNew={isNew} />}
      <div className={styles.bar}>
        {isNew ? (
          <h2>
            <Trans>Behaviours to teach</Trans>
          </h2>
        ) : (
          <h1>
            <Trans>Behaviours</Trans>
          </h1>
        )}
        {!onlyPlays && (
          <Button icon="plus" onClick={() => setMaking(true)}>
            <Trans>New behaviour</Trans>
          </Button>
        )}
      </div>
      <ul className={styles.cards}>
        {shown.map((behaviour) => (
          <li key={behaviour.id}>
            <Card
              behaviour={behaviour}
              level={isNew ? "h3" : "h2"}
              game={
                isOneGame ? undefined : games?.find(({ name }) => name === behaviour.game)?.title
              }
              besideOthers={!isOneGame}
              latest={worthShowing(runs.data?.filter((run) => run.behaviour_id === behaviour.id))}
            />
          </li>
        ))}
      </ul>
      {more}
      {making && <NewBehaviourDialog onClose={() => setMaking(false)} />}
    </>
  );
}

/** Returns behaviours with those that people have made first, which they come back for. */
function ownFirst(behaviours: readonly Behaviour[]): readonly Behaviour[] {
  return behaviours.toSorted((a, b) => Number(a.built_in) - Number(b.built_in));
}

/** Whether nobody has played or trained a behaviour, apart from an example's scripted player. */
function isUntouched(behaviour: Behaviour, runs: readonly Run[] = []): boolean {
  if (isEmpty(behaviour)) return true;
  const ofIt = runs.filter((run) => run.behaviour_id === behaviour.id);
  const onlyExamples = ofIt.length > 0 && ofIt.every((run) => run.example);
  return onlyExamples && (behaviour.has_example || behaviour.n_recordings === 0);
}

/** Pictures of games beside the first step. */
const WALL = 12;

function Welcome({ all }: { all: readonly Behaviour[] }) {
  const { data: games = [] } = useQuery(catalogueQuery);
  const first = all.find(isEmpty) ?? all[0];
  const example = all.find((one) => one.built_in && one.slug === "column-1");
  return (
    <>
      <section className={styles.hero}>
        <div className={styles.pitch}>
          <h1>
            <Trans>Teach an imitator by showing it better and worse games</Trans>
          </h1>
          <p>
            <Trans>
              Play a game for twenty seconds at a time, put your games in order from best to worst,
              and Tril learns from the order what you were after.
            </Trans>
          </p>
          <div className={styles.actions}>
            {first && (
              <ButtonLink kind="primary" large to={`/behaviours/${first.id}/play`}>
                <Trans>Play your first game</Trans>
              </ButtonLink>
            )}
            <FinishedExampleButton />
            {example && isEmpty(example) && <ExampleButton behaviour={example} />}
          </div>
        </div>
        <Link className={styles.wall} to="/games">
          {spread(games, WALL).map(({ name, picture_url: picture }) => (
            <img key={name} src={picture} alt="" />
          ))}
          <span>
            <Trans>All {games.length} games</Trans>
          </span>
        </Link>
      </section>
      <ol className={styles.how} aria-label={t`How it works`}>
        <li>
          <strong>
            <Trans>1. Play</Trans>
          </strong>
          <span>
            <Trans>Three games at your best, and four from good to hopeless.</Trans>
          </span>
        </li>
        <li>
          <strong>
            <Trans>2. Rank</Trans>
          </strong>
          <span>
            <Trans>Drag them into an order. Ties are fine.</Trans>
          </span>
        </li>
        <li>
          <strong>
            <Trans>3. Train</Trans>
          </strong>
          <span>
            <Trans>Tril learns a reward from the order, then trains an imitator to earn it.</Trans>
          </span>
        </li>
        <li>
          <strong>
            <Trans>4. Look</Trans>
          </strong>
          <span>
            <Trans>Side by side: the imitator, a clone that copies your best games, and you.</Trans>
          </span>
        </li>
      </ol>
    </>
  );
}

/** Returns so many of a list, from all over it. */
function spread<T>(list: readonly T[], n: number): readonly T[] {
  return list.filter(
    (_, at) => Math.floor((at * n) / list.length) !== Math.floor(((at - 1) * n) / list.length),
  );
}

/** The newest run that is active or done; otherwise the newest of all. */
function worthShowing(runs: readonly Run[] = []): Run | undefined {
  return runs.find((run) => isActive(run) || run.status === "done") ?? runs[0];
}

function Card({
  behaviour,
  level: Heading,
  game,
  besideOthers,
  latest,
}: {
  behaviour: Behaviour;
  level: "h2" | "h3";
  /** The title of its game, where there are several. */
  game: string | undefined;
  /** Whether there are behaviours of other games. */
  besideOthers: boolean;
  latest: Run | undefined;
}) {
  return (
    <article className={styles.card}>
      <BehaviourMark behaviour={behaviour} besideOthers={besideOthers} />
      <div className={styles.words}>
        <Heading className={styles.heading}>
          <Link className={styles.link} to={`/behaviours/${behaviour.id}`}>
            {behaviour.name}
          </Link>
        </Heading>
        {game !== undefined && <p className={styles.counts}>{game}</p>}
        <p className={styles.description}>{behaviour.description}</p>
        <p className={styles.counts}>{countsOf(behaviour)}</p>
        {latest && <Latest run={latest} behaviour={behaviour} />}
      </div>
    </article>
  );
}

/** Whether a behaviour has neither games nor runs. */
function isEmpty(behaviour: Behaviour): boolean {
  return behaviour.n_recordings === 0 && behaviour.n_ranked === 0 && behaviour.n_runs === 0;
}

function countsOf(behaviour: Behaviour): string {
  if (isEmpty(behaviour)) return t`Nothing played yet`;
  return [
    plural(behaviour.n_recordings, { one: "# recording", other: "# recordings" }),
    // Borrowed ones, too, which are no recordings of this behaviour.
    t`${behaviour.n_ranked} ranked`,
    t`${behaviour.n_perfect} starred`,
    ...(behaviour.n_runs > 0 ? [plural(behaviour.n_runs, { one: "# run", other: "# runs" })] : []),
  ].join(", ");
}

function Latest({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const targets = run.headline?.imitator?.targets;
  const shares = run.headline?.understood;
  if (!isActive(run) && !behaviour.target && shares?.imitator) {
    return (
      <p className={styles.result}>
        <ActorMark actor="imitator">
          <Trans>Imitator {wholeShare(shares.imitator.mean)}, by what Tril understood</Trans>
        </ActorMark>
        <ActorMark actor="person">
          <Trans>Your best games {wholeShare(shares.best.mean)}</Trans>
        </ActorMark>
      </p>
    );
  }
  if (isActive(run) || !targets || !behaviour.target) {
    return (
      <p className={styles.result}>
        <Trans>Latest run: {statusLine(run)}</Trans>
      </p>
    );
  }
  const clone = run.headline?.clone?.targets;
  const of = behaviour.target.length;
  return (
    <p className={styles.result}>
      <ActorMark actor="imitator">
        <Trans>
          Imitator hits {fixed(targets.mean, 1)} of {of} ({bounds(targets)})
        </Trans>
      </ActorMark>
      {clone && (
        <ActorMark actor="clone">
          <Trans>
            Clone hits {fixed(clone.mean, 1)} of {of} ({bounds(clone)})
          </Trans>
        </ActorMark>
      )}
    </p>
  );
}
