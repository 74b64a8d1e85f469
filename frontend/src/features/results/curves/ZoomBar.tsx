import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { Button, IconButton } from "@/components/controls/Button";

import type { Zoom } from "./zoom";
import { moved, zoomedIn, zoomedOut } from "./zoom";
import styles from "./ZoomBar.module.css";

/** Buttons for what a drag over a chart does: zoom, move, show everything. */
export function ZoomBar({ zoom, of }: { zoom: Zoom; of: string }) {
  const { range, change } = zoom;
  return (
    <div className={styles.bar} role="group" aria-label={t`Zoom: ${of}`}>
      <IconButton icon="plus" label={t`Zoom in`} onClick={() => change(zoomedIn(zoom))} />
      {range && (
        <>
          <IconButton icon="minus" label={t`Zoom out`} onClick={() => change(zoomedOut(zoom))} />
          <IconButton
            icon="arrowLeft"
            label={t`Earlier`}
            onClick={() => change(moved(zoom, -0.5))}
          />
          <IconButton icon="arrowRight" label={t`Later`} onClick={() => change(moved(zoom, 0.5))} />
          <Button kind="quiet" onClick={() => change(null)}>
            <Trans>Show everything</Trans>
          </Button>
        </>
      )}
    </div>
  );
}
