import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";

import { playerQuery } from "@/api/system";
import { ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";

import { Browsers } from "./Browsers";
import { Invitations } from "./Invitations";
import { Keys } from "./Keys";
import { Log } from "./Log";
import styles from "./PeoplePage.module.css";
import { Persons } from "./Persons";

/** Who gets in, and what they did; for the owner. */
export function PeoplePage() {
  const { data: player, error, refetch } = useQuery(playerQuery);
  if (error && !player) {
    return <Failed what={t`The page`} error={error} onRetry={() => void refetch()} />;
  }
  if (!player) return <Loading what={t`the page`} rows={3} />;
  if (player.role !== "owner") return <OwnersOnly />;
  return (
    <>
      <PageTitle>{t`People · Tril`}</PageTitle>
      <h1>
        <Trans>People</Trans>
      </h1>
      <div className={styles.columns}>
        <section className={styles.section} aria-labelledby="invitations">
          <h2 id="invitations">
            <Trans>Invitations</Trans>
          </h2>
          <p className={styles.hint}>
            <Trans>
              Anyone with the link joins by giving a name. Players play one behaviour and see only
              their own games. Revoking a link stops newcomers; those who joined stay until you sign
              them out.
            </Trans>
          </p>
          <Invitations />
        </section>
        <section className={styles.section} aria-labelledby="roles">
          <h2 id="roles">
            <Trans>What people may do</Trans>
          </h2>
          <p className={styles.hint}>
            <Trans>
              A change takes effect within seconds. Anyone who becomes a player keeps the games
              played so far, and sees only those of the behaviours they play.
            </Trans>
          </p>
          <Persons />
        </section>
        <section className={styles.section} aria-labelledby="browsers">
          <h2 id="browsers">
            <Trans>Signed-in browsers</Trans>
          </h2>
          <Browsers />
          <p className={styles.hint}>
            <Trans>
              <code>tril address --new</code> in a terminal signs everybody out and makes earlier
              addresses useless.
            </Trans>
          </p>
        </section>
        <section className={styles.section} aria-labelledby="keys">
          <h2 id="keys">
            <Trans>Keys for scripts</Trans>
          </h2>
          <p className={styles.hint}>
            <Trans>
              A script sends its key as <code>Authorization: Bearer</code>. What it does is logged
              as yours.
            </Trans>
          </p>
          <Keys />
        </section>
      </div>
      <section className={styles.section} aria-labelledby="log">
        <h2 id="log">
          <Trans>Log</Trans>
        </h2>
        <Log />
      </section>
    </>
  );
}

function OwnersOnly() {
  return (
    <Empty
      level="h1"
      title={t`Only the owner sees this page`}
      actions={
        <ButtonLink to="/">
          <Trans>All behaviours</Trans>
        </ButtonLink>
      }
    >
      <p>
        <Trans>Ask whoever runs this server.</Trans>
      </p>
    </Empty>
  );
}
