import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import type { ReactNode } from "react";
import { Link } from "react-router";

import { Button } from "@/components/controls/Button";
import { SHOW_GHOST, SHOW_LATENCY, SHOW_TARGETS, SOUND } from "@/features/play/settings/settings";
import { type Setting, useSetting } from "@/features/play/settings/stored";
import { canSound } from "@/features/play/sound/use-sounds";
import type { Marks } from "@/games/view";
import { numberedName } from "@/lib/recordings";
import { playedBy, actorColour } from "@/lib/actors";

import styles from "./Toggles.module.css";

interface TogglesProps {
  hasTarget: boolean;
  hasGhost: boolean;
  marks: Marks;
  onChooseKeys: () => void;
  onFullscreen: () => void;
}

/** Switches for the marks, the sound and the latency display, and the marks' legend. */
export function Toggles({ hasTarget, hasGhost, marks, onChooseKeys, onFullscreen }: TogglesProps) {
  return (
    <div>
      <div className={styles.toggles}>
        {hasTarget && (
          <Toggle setting={SHOW_TARGETS} keyName="T">
            <Trans>Outline targets</Trans>
          </Toggle>
        )}
        {hasGhost && (
          <Toggle setting={SHOW_GHOST} keyName="G">
            <Trans>Ghost</Trans>
          </Toggle>
        )}
        {canSound() && (
          <Toggle setting={SOUND} keyName="M">
            <Trans>Sound</Trans>
          </Toggle>
        )}
        <Toggle setting={SHOW_LATENCY} keyName="L">
          <Trans>Latency</Trans>
        </Toggle>
        <Button kind="quiet" onClick={onFullscreen}>
          <Trans>
            Fullscreen <kbd>F</kbd>
          </Trans>
        </Button>
        <Button kind="quiet" onClick={onChooseKeys}>
          <Trans>Change the keys</Trans>
        </Button>
      </div>
      <Legend {...marks} />
    </div>
  );
}

function Toggle({
  setting,
  keyName,
  children,
}: {
  setting: Setting<boolean>;
  /** The key that toggles it. */
  keyName: string;
  children: ReactNode;
}) {
  const [isOn, turn] = useSetting(setting);
  return (
    <Button kind="quiet" aria-pressed={isOn} onClick={() => turn(!isOn)}>
      {children} <kbd>{keyName}</kbd>
    </Button>
  );
}

/** Explains the marks drawn over the game. */
function Legend({ target, ghost }: Marks) {
  if (!target && !ghost) return null;
  return (
    <ul className={styles.legend} aria-label={t`Drawn over the game, and not recorded`}>
      {target && (
        <li>
          <svg className={styles.swatch} viewBox="0 0 14 14" aria-hidden="true">
            <path d="M2.5 1.5h9v11h-9z" fill="none" stroke="var(--accent)" />
          </svg>
          <span>
            <Trans>remaining targets</Trans>
          </span>
        </li>
      )}
      {ghost && (
        <li>
          <svg className={styles.swatch} viewBox="0 0 14 14" aria-hidden="true">
            <path
              d="M5.5 2h3v6h2v4h-7V8h2z"
              fill={actorColour(playedBy(ghost.source))}
              opacity="0.75"
            />
          </svg>
          <span>
            <Trans>
              the player at this moment of the best demonstration,{" "}
              <Link to={`/recordings/${ghost.recording_id}`}>{numberedName(ghost.number)}</Link>
            </Trans>
          </span>
        </li>
      )}
    </ul>
  );
}
