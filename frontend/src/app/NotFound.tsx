import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { ButtonLink } from "@/components/controls/Button";
import { LostGame } from "@/components/feedback/LostGame";
import { Empty } from "@/components/feedback/States";

/** Shown for an unknown address. */
export function NotFound() {
  return (
    <Empty
      level="h1"
      title={t`Page not found`}
      picture={<LostGame />}
      actions={
        <ButtonLink to="/">
          <Trans>All behaviours</Trans>
        </ButtonLink>
      }
    >
      <p>
        <Trans>The address is wrong, or what was here has been deleted.</Trans>
      </p>
    </Empty>
  );
}
