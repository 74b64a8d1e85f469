import { useState } from "react";
import { useSearchParams } from "react-router";

import { Button } from "@/components/controls/Button";

import styles from "./Tour.module.css";
import { hasSeenTour, noteTourSeen } from "./tour-seen";

const STEPS = [
  {
    title: "Play",
    text: "Choose a behaviour and play it for twenty seconds: arrows move, space fires. Play some games badly on purpose, since what is worse teaches as much as what is better.",
  },
  {
    title: "Keep",
    text: "After a game, keep it or discard it. Give a star to games that went perfectly: the clone, a plain copy of them, learns from those.",
  },
  {
    title: "Rank",
    text: "Drag your games into an order from best to worst, ties allowed. The order is all that Tril learns from; it never sees a score.",
  },
  {
    title: "Train",
    text: "Press Train. Tril learns a reward from your order, then an agent that earns it. You can go on playing meanwhile.",
  },
  {
    title: "Look",
    text: "The run’s page says what the agent has learned, beside the clone and your own games: watch it, take over from it, and rank its games to teach it more.",
  },
] as const;

/** A tour of five steps: on the empty home page until it was seen, and where `?tour` asks for it. */
export function Tour({ isNew }: { isNew: boolean }) {
  const [search, setSearch] = useSearchParams();
  const [seen, setSeen] = useState(hasSeenTour);
  const [at, setAt] = useState(0);
  const asked = search.has("tour");
  const step = STEPS[at];
  if (!step || (!asked && (seen || !isNew))) return null;

  function end() {
    noteTourSeen();
    setSeen(true);
    setAt(0);
    if (asked) setSearch({}, { replace: true });
  }

  const isLast = at === STEPS.length - 1;
  return (
    <section className={styles.tour} aria-label="Tour">
      <div aria-live="polite">
        <div className={styles.head}>
          <h2>{step.title}</h2>
          <span className={styles.place}>
            Step {at + 1} of {STEPS.length}
          </span>
        </div>
        <p>{step.text}</p>
      </div>
      <div className={styles.actions}>
        {at > 0 && <Button onClick={() => setAt(at - 1)}>Back</Button>}
        <Button kind="primary" onClick={() => (isLast ? end() : setAt(at + 1))}>
          {isLast ? "Finish the tour" : "Next"}
        </Button>
        {!isLast && (
          <Button kind="quiet" onClick={end}>
            Skip the tour
          </Button>
        )}
      </div>
    </section>
  );
}
