import { Trans } from "@lingui/react/macro";
import { type ReactNode, useState } from "react";

import { Button } from "@/components/controls/Button";

/** How many items are shown at first, and how many more at a time. */
const STEP = 100;

/** Returns the first items of a list, more each time the button is pressed, and the button. */
export function useFirst<T>(items: readonly T[], step = STEP): [readonly T[], ReactNode] {
  const [most, setMost] = useState(step);
  const nLeft = items.length - most;
  const more = nLeft > 0 && (
    <Button kind="quiet" onClick={() => setMost(most + step)}>
      <Trans>
        Show {Math.min(step, nLeft)} more of {items.length}
      </Trans>
    </Button>
  );
  return [nLeft > 0 ? items.slice(0, most) : items, more];
}
