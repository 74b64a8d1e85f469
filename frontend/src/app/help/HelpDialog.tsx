import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { matchPath, useLocation } from "react-router";

import { behaviourQuery } from "@/api/behaviours";
import { gameQuery } from "@/games/catalogue";
import type { TaughtGame } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { keysSetting, useKeyNames } from "@/features/play/input/keys";
import { readSetting } from "@/features/play/settings/stored";

import styles from "./HelpDialog.module.css";
import { keySections } from "./page-keys";

/** The keys that act on this page, and the way to the tour. */
export function HelpDialog({ onClose }: { onClose: () => void }) {
  const { pathname } = useLocation();
  const game = usePlayedOn(pathname);
  const nameOf = useKeyNames();
  return (
    <Dialog title={t`Keys on this page`} onClose={onClose} width="30rem">
      <div className={styles.body}>
        {keySections(pathname, game && { game, keys: readSetting(keysSetting(game)) }, nameOf).map(
          ({ title, rows }) => (
            <section key={title} aria-label={title}>
              <h3>{title}</h3>
              <dl className={styles.keys}>
                {rows.map((row) => (
                  <div key={row.effect} style={{ display: "contents" }}>
                    <dt>
                      {row.keys.map((key) => (
                        <kbd key={key}>{key}</kbd>
                      ))}
                    </dt>
                    <dd>{row.effect}</dd>
                  </div>
                ))}
              </dl>
            </section>
          ),
        )}
        <div>
          <ButtonLink to="/?tour" onClick={onClose}>
            <Trans>Take the tour of Tril</Trans>
          </ButtonLink>
        </div>
      </div>
    </Dialog>
  );
}

/** The game that is played on the page at a path; null on other pages, and until it is known. */
function usePlayedOn(path: string): TaughtGame | null {
  const id = Number(matchPath("/behaviours/:id/play", path)?.params.id ?? NaN);
  const { data: behaviour } = useQuery({ ...behaviourQuery(id), enabled: Number.isInteger(id) });
  const name = behaviour?.game;
  const { data: game } = useQuery({ ...gameQuery(name ?? ""), enabled: name !== undefined });
  return game ?? null;
}
