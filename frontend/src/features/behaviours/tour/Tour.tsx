import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useState } from "react";
import { useSearchParams } from "react-router";

import { Button } from "@/components/controls/Button";

import styles from "./Tour.module.css";
import { hasSeenTour, noteTourSeen } from "./tour-seen";

const steps = () =>
  [
    {
      title: t`Play`,
      text: t`Choose a behaviour and play; the keys are beside the game. Play some games badly on purpose: Tril learns from the difference.`,
    },
    {
      title: t`Keep`,
      text: t`Keep each game or discard it. Star the perfect ones: the clone copies them, and the reward learns from them.`,
    },
    {
      title: t`Rank`,
      text: t`Drag your games into an order from best to worst, ties allowed. Tril learns from this order and from the games with a star; it never sees a score.`,
    },
    {
      title: t`Train`,
      text: t`Press Train. Tril learns a reward from your order, then trains an imitator to earn it. You can go on playing meanwhile.`,
    },
    {
      title: t`Look`,
      text: t`See what the imitator learned, beside the clone and your own games. Watch it, take over, or rank its games to teach it more.`,
    },
  ] as const;

/** A tour of five steps: on the empty home page until it was seen, and where `?tour` asks for it. */
export function Tour({ isNew }: { isNew: boolean }) {
  const [search, setSearch] = useSearchParams();
  const [seen, setSeen] = useState(hasSeenTour);
  const [at, setAt] = useState(0);
  const asked = search.has("tour");
  const step = steps()[at];
  if (!step || (!asked && (seen || !isNew))) return null;

  function end() {
    noteTourSeen();
    setSeen(true);
    setAt(0);
    if (asked) setSearch({}, { replace: true });
  }

  const isLast = at === steps().length - 1;
  return (
    <section className={styles.tour} aria-label={t`Tour`}>
      <div aria-live="polite">
        <div className={styles.head}>
          <h2>{step.title}</h2>
          <span className={styles.place}>
            <Trans>
              Step {at + 1} of {steps().length}
            </Trans>
          </span>
        </div>
        <p>{step.text}</p>
      </div>
      <div className={styles.actions}>
        <Button kind="primary" onClick={() => (isLast ? end() : setAt(at + 1))}>
          {isLast ? t`Finish the tour` : t`Next`}
        </Button>
        {at > 0 && (
          <Button onClick={() => setAt(at - 1)}>
            <Trans>Back</Trans>
          </Button>
        )}
        {!isLast && (
          <Button kind="quiet" onClick={end}>
            <Trans>Skip the tour</Trans>
          </Button>
        )}
      </div>
    </section>
  );
}
