import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useSearchParams } from "react-router";

import { recipesQuery } from "@/api/runs";
import type { Behaviour } from "@/api/types";
import { Failed, Loading, Notice } from "@/components/feedback/States";

import { editsFrom } from "./form";
import { TrainForm } from "./TrainForm";
import styles from "./TrainPage.module.css";

/** Starts a run on the current ranking, which continues the run that the address names, if any. */
export function TrainPage({ behaviour }: { behaviour: Behaviour }) {
  const [search, setSearch] = useSearchParams();
  const { data: recipes, error, refetch } = useQuery(recipesQuery(behaviour));
  if (error && !recipes) {
    return <Failed what={t`The recipes`} error={error} onRetry={() => void refetch()} />;
  }
  if (!recipes?.[0]) return <Loading what={t`the recipes`} rows={3} />;
  const wanted = search.get("recipe");
  const known = recipes.find(({ name }) => name === wanted);
  const first = known ?? recipes[0];
  return (
    <div className={styles.page}>
      {wanted !== null && !known && (
        <div className={styles.notice}>
          <Notice live>
            <p>
              <Trans>
                This version of Tril has no recipe <strong>{wanted}</strong> for this game.{" "}
                <strong>{first.name}</strong> is chosen instead.
              </Trans>
            </p>
          </Notice>
        </div>
      )}
      <TrainForm
        behaviour={behaviour}
        recipes={recipes}
        first={first}
        filledIn={editsFrom(search)}
        parentId={search.get("continue")}
        onParentRemoved={() => {
          search.delete("continue");
          setSearch(search, { replace: true });
        }}
      />
      <aside className={styles.side} aria-label={t`What a run does`}>
        <h2>
          <Trans>What a run does</Trans>
        </h2>
        <ol className={styles.stages}>
          {recipes[0].stages.map((stage, index) => (
            <li key={stage.name}>
              <span>{index + 1}</span>
              <span>
                <strong>{stage.label}</strong>
                {stage.summary}
              </span>
            </li>
          ))}
        </ol>
        <p>
          <Trans>
            A run uses the ranking as it is when you press the button. You can go on playing and
            ranking meanwhile.
          </Trans>
        </p>
      </aside>
    </div>
  );
}
