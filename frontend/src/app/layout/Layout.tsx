import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useState, useSyncExternalStore } from "react";
import { Link, NavLink, Outlet, ScrollRestoration, useLocation } from "react-router";

import { connection } from "@/api/connection";
import { listenToChanges } from "@/app/changes/change-stream";
import { Invalidator } from "@/app/changes/invalidation";
import { Help } from "@/app/help/Help";
import { useActiveRuns } from "@/app/runs/use-active-runs";
import { Unauthorised } from "@/app/Unauthorised";
import { Logo } from "@/app/Logo";
import { Button, IconButton } from "@/components/controls/Button";
import { TitleContext } from "@/components/PageTitle";
import { followLayout } from "@/lib/browser/keyboard";

import styles from "./Layout.module.css";
import { PlayerMenu } from "./PlayerMenu";
import { StatusMenu } from "./StatusMenu";
import { applyTheme, nextTheme, readTheme } from "./theme";

/** The frame of every page: the bar at the top, the connection banner, the page itself. */
export function Layout() {
  const { reachable, authorised } = useSyncExternalStore(connection.subscribe, connection.snapshot);
  useChanges(authorised);
  useFocusOnNewPage();
  useEffect(followLayout, []);
  if (!authorised) return <Unauthorised />;
  return <Frame reachable={reachable} />;
}

function Frame({ reachable }: { reachable: boolean }) {
  const title = useActiveRuns();
  return (
    <TitleContext value={title}>
      <a className={styles.skip} href="#main">
        <Trans>Skip to content</Trans>
      </a>
      <header>
        {!reachable && <UnreachableBanner />}
        <div className={styles.bar}>
          <Link to="/" className={styles.brand}>
            <Logo scale={2} />
            Tril
          </Link>
          <NavLink to="/" end className={styles.nav ?? ""}>
            <Trans>Behaviours</Trans>
          </NavLink>
          <NavLink to="/games" className={styles.nav ?? ""}>
            <Trans>Games</Trans>
          </NavLink>
          <div className={styles.right}>
            <StatusMenu />
            <PlayerMenu />
            <Help />
            <ThemeButton />
          </div>
        </div>
      </header>
      <main id="main" className={styles.main} tabIndex={-1}>
        <Outlet />
      </main>
      <ScrollRestoration />
    </TitleContext>
  );
}

/** Keeps the queries up to date with the server. */
function useChanges(active: boolean): void {
  const client = useQueryClient();
  useEffect(() => {
    if (!active) return undefined;
    const invalidator = new Invalidator(client);
    const stop = listenToChanges({
      onChange: (change) => invalidator.add(change),
      onReconnect: () => invalidator.all(),
      onLive: (live) => {
        const before = connection.snapshot();
        // Silence that lasts although the stream was opened anew: nothing passes.
        const reachable = live || (before.reachable && before.live);
        connection.update({ live, reachable });
      },
    });
    return () => {
      stop();
      invalidator.stop();
    };
  }, [active, client]);
}

/** Moves the focus to the top of the page after navigation, for keyboards and screen readers. */
function useFocusOnNewPage(): void {
  const { pathname } = useLocation();
  const [first] = useState(pathname);
  const [left, setLeft] = useState(false);
  if (!left && pathname !== first) setLeft(true);
  useEffect(() => {
    if (left) document.getElementById("main")?.focus({ preventScroll: true });
  }, [left, pathname]);
}

function UnreachableBanner() {
  const client = useQueryClient();
  const [trying, setTrying] = useState(false);
  const retry = () => {
    setTrying(true);
    void client.invalidateQueries().finally(() => setTrying(false));
  };
  return (
    <div className={styles.banner} role="alert">
      <span>
        <Trans>
          <strong>Tril&rsquo;s server doesn&rsquo;t answer.</strong> Is <code>tril up</code> still
          running? Nothing that was saved is lost.
        </Trans>
      </span>
      <Button onClick={retry} disabled={trying} icon="restart">
        {trying ? t`Trying…` : t`Try again`}
      </Button>
    </div>
  );
}

const THEME_ICONS = { system: "system", light: "sun", dark: "moon" } as const;
const themeNames = () => ({ system: t`as the system`, light: t`light`, dark: t`dark` }) as const;

function ThemeButton() {
  const [theme, setTheme] = useState(readTheme);
  return (
    <IconButton
      icon={THEME_ICONS[theme]}
      label={t`Theme: ${themeNames()[theme]}. Change`}
      onClick={() => {
        const next = nextTheme(theme);
        applyTheme(next);
        setTheme(next);
      }}
    />
  );
}
