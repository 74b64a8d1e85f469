import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { Link } from "react-router";

import { checklistQuery } from "@/api/behaviours";
import type { Behaviour } from "@/api/types";
import { Icon } from "@/components/controls/Icon";
import { numberedName } from "@/lib/recordings";

import styles from "./Checklist.module.css";

/** The demonstrations that an agent learns well from, done and missing. */
export function Checklist({ behaviour }: { behaviour: Behaviour }) {
  const { data } = useQuery(checklistQuery(behaviour.id));
  if (!data || data.planned.length === 0) return null;
  const { planned } = data;
  const done = planned.filter((one) => one.recording_id !== null).length;
  const next = planned.find((one) => one.recording_id === null);
  return (
    <details className={styles.checklist}>
      <summary>
        <Trans>
          Demonstrations: {done} of {planned.length}
        </Trans>
        {next && (
          <span>
            {" "}
            <Trans>Next: {next.description}</Trans>
          </span>
        )}
      </summary>
      <p className={styles.checklistRule}>
        <Trans>
          Only games that you survive to the end count, not those that were stopped or lost.
        </Trans>
      </p>
      <ol aria-label={t`Demonstrations, best first`}>
        {planned.map(({ number, description, recording_id: id, recording_number: named }) => (
          <li key={number} className={id === null ? undefined : styles.ticked}>
            <Icon name={id === null ? "play" : "check"} />
            <span>
              {description}
              {id === null ? (
                <span className="visually-hidden">
                  , <Trans>missing</Trans>
                </span>
              ) : (
                <>
                  {" "}
                  <Link to={`/recordings/${id}`}>{numberedName(named)}</Link>
                </>
              )}
            </span>
          </li>
        ))}
      </ol>
    </details>
  );
}
