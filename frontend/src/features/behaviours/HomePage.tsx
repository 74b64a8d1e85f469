import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { Link } from "react-router";

import { behavioursQuery } from "@/api/behaviours";
import { runsQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { AlienGrid } from "@/components/game/AlienGrid";
import { ThingMark } from "@/components/game/ThingMark";
import { PageTitle } from "@/components/PageTitle";
import { Tour } from "@/features/behaviours/tour/Tour";
import { bounds, count, fixed } from "@/lib/format";
import { isActive, statusLine } from "@/lib/runs";

import { ExampleButton } from "./ExampleButton";
import { FinishedExampleButton } from "./FinishedExampleButton";
import styles from "./HomePage.module.css";
import { NewBehaviourDialog } from "./NewBehaviourDialog";

/** The list of behaviours; on first use, an introduction too. */
export function HomePage() {
  const behaviours = useQuery(behavioursQuery);
  const runs = useQuery(runsQuery());
  const [making, setMaking] = useState(false);

  if (behaviours.error && !behaviours.data) {
    return (
      <Failed
        what="The behaviours"
        error={behaviours.error}
        onRetry={() => void behaviours.refetch()}
      />
    );
  }
  if (!behaviours.data) return <Loading what="the behaviours" rows={4} height="6rem" />;
  const all = behaviours.data;
  const isNew = all.every((one) => one.n_recordings === 0 && one.n_runs === 0);
  const first = all[0];
  return (
    <>
      <PageTitle>Tril</PageTitle>
      {isNew && first && <Welcome first={first} all={all} />}
      <Tour isNew={isNew} />
      <div className={styles.bar}>
        {isNew ? <h2>Behaviours to teach</h2> : <h1>Behaviours</h1>}
        <Button icon="plus" onClick={() => setMaking(true)}>
          New behaviour
        </Button>
      </div>
      <ul className={styles.cards}>
        {all.map((behaviour) => (
          <li key={behaviour.id}>
            <Card
              behaviour={behaviour}
              level={isNew ? "h3" : "h2"}
              latest={worthShowing(runs.data?.filter((run) => run.behaviour_id === behaviour.id))}
            />
          </li>
        ))}
      </ul>
      {making && <NewBehaviourDialog onClose={() => setMaking(false)} />}
    </>
  );
}

function Welcome({ first, all }: { first: Behaviour; all: readonly Behaviour[] }) {
  const example = all.find((one) => one.built_in && one.slug === "column-1");
  return (
    <>
      <section className={styles.hero}>
        <h1>Teach an agent by showing it better and worse games</h1>
        <p>
          Play Space Invaders for twenty seconds at a time, put your games in order from best to
          worst, and Tril learns from the order what you were after.
        </p>
        <div className={styles.actions}>
          <ButtonLink kind="primary" large to={`/behaviours/${first.id}/play`}>
            Play your first game
          </ButtonLink>
          <FinishedExampleButton />
          {example && <ExampleButton behaviour={example} large />}
        </div>
      </section>
      <ol className={styles.how} aria-label="How it works">
        <li>
          <strong>1. Play</strong>
          <span>Good games and deliberately bad ones, about a dozen.</span>
        </li>
        <li>
          <strong>2. Rank</strong>
          <span>Drag them into an order. Ties are fine.</span>
        </li>
        <li>
          <strong>3. Train</strong>
          <span>Tril learns a reward from the order, then an agent that earns it.</span>
        </li>
        <li>
          <strong>4. Look</strong>
          <span>The agent, a plain copy of your best games, and you, side by side.</span>
        </li>
      </ol>
    </>
  );
}

/** The newest run that is active or done; otherwise the newest of all. */
function worthShowing(runs: readonly Run[] = []): Run | undefined {
  return runs.find((run) => isActive(run) || run.status === "done") ?? runs[0];
}

function Card({
  behaviour,
  level: Heading,
  latest,
}: {
  behaviour: Behaviour;
  level: "h2" | "h3";
  latest: Run | undefined;
}) {
  return (
    <article className={styles.card}>
      <AlienGrid target={behaviour.target} label="" />
      <div className={styles.words}>
        <Heading className={styles.heading}>
          <Link className={styles.link} to={`/behaviours/${behaviour.id}`}>
            {behaviour.name}
          </Link>
        </Heading>
        <p className={styles.description}>{behaviour.description}</p>
        <p className={styles.counts}>{countsOf(behaviour)}</p>
        {latest && <Latest run={latest} behaviour={behaviour} />}
      </div>
    </article>
  );
}

function countsOf(behaviour: Behaviour): string {
  if (behaviour.n_recordings === 0 && behaviour.n_runs === 0) return "Nothing played yet";
  return [
    count(behaviour.n_recordings, "recording"),
    `${behaviour.n_ranked} ranked`,
    `${behaviour.n_perfect} perfect`,
    ...(behaviour.n_runs > 0 ? [count(behaviour.n_runs, "run")] : []),
  ].join(", ");
}

function Latest({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const targets = run.headline?.imitator?.targets;
  if (isActive(run) || !targets || !behaviour.target) {
    return <p className={styles.result}>Latest run: {statusLine(run)}</p>;
  }
  const clone = run.headline?.clone?.targets;
  const of = behaviour.target.length;
  return (
    <p className={styles.result}>
      <ThingMark thing="imitator">
        Imitator hits {fixed(targets.mean, 1)} of {of} ({bounds(targets)})
      </ThingMark>
      {clone && (
        <ThingMark thing="clone">
          Clone hits {fixed(clone.mean, 1)} of {of} ({bounds(clone)})
        </ThingMark>
      )}
    </p>
  );
}
