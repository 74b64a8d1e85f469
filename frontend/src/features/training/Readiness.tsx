import { Link } from "react-router";

import type { Behaviour } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { count } from "@/lib/format";

interface ReadinessProps {
  behaviour: Behaviour;
  missing: string | null;
  /** Whether the run trains on the scripted example instead. */
  example: boolean;
}

/** What the run would learn from, or what is missing. */
export function Readiness({ behaviour, missing, example }: ReadinessProps) {
  const at = `/behaviours/${behaviour.id}`;
  if (missing === null) {
    return (
      <Notice tone="calm" icon="check">
        <p>
          {count(behaviour.n_ranked, "ranked recording")} and{" "}
          {count(behaviour.n_perfect, "perfect one")} go into the run.{" "}
          <Link to={`${at}/rank`}>Look at the ranking</Link>
        </p>
      </Notice>
    );
  }
  if (example) {
    return (
      <Notice tone="calm">
        <p>
          You have not played yet, so this run uses an example: its games come from a scripted
          player, not a person, and Tril ranks them.
        </p>
        <Link to={`${at}/play`}>Play yourself instead</Link>
      </Notice>
    );
  }
  return (
    <Notice>
      <p>{missing}</p>
      <Link to={`${at}/rank`}>Go to Rank</Link>
    </Notice>
  );
}

/** What prevents a run; null if nothing does. */
export function missingFor(behaviour: Behaviour): string | null {
  if (behaviour.n_ranked < 2) return "Rank at least two recordings, in two tiers or more.";
  if (behaviour.n_perfect < 1) {
    return "Mark at least one recording as perfect: the clone learns from those.";
  }
  return null;
}
