import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Recording } from "@/api/types";
import { Badge } from "@/components/feedback/Badge";
import { fixed, percent } from "@/lib/format";
import { isUndecided } from "@/lib/recordings";

/** Whether a replay reproduced the recording. */
export function VerifiedBadge({ recording }: { recording: Recording }) {
  if (recording.state === "unfinished") {
    return (
      <Badge tone="warn" icon="clock">
        <Trans>unfinished</Trans>
      </Badge>
    );
  }
  if (isUndecided(recording)) {
    return (
      <Badge tone="warn" icon="clock">
        <Trans>undecided</Trans>
      </Badge>
    );
  }
  switch (recording.verification) {
    case "verified":
      return (
        <Badge tone="good" icon="check" title={t`A replay reproduced the recording exactly.`}>
          <Trans>verified</Trans>
        </Badge>
      );
    case "failed":
      return (
        <Badge tone="bad" icon="alert">
          <Trans>not verified: {recording.verification_note}</Trans>
        </Badge>
      );
    case "pending":
      return (
        <Badge icon="clock">
          <Trans>being verified</Trans>
        </Badge>
      );
  }
}

/** Marks a game that its player saw with noticeable delay. */
export function LatencyBadge({ recording }: { recording: Recording }) {
  const { latency, n_frames } = recording;
  if (!latency?.is_bad) return null;
  const { p50_ms, p95_ms, frames_dropped } = latency;
  const parts = [t`${percent(frames_dropped / Math.max(1, n_frames), 0)} of the frames not drawn`];
  if (p50_ms !== null && p95_ms !== null) {
    parts.unshift(t`from key to screen ${fixed(p50_ms, 0)} ms, 95% within ${fixed(p95_ms, 0)} ms`);
  }
  return (
    <Badge icon="clock" title={t`Played with delay: ${parts.join("; ")}.`}>
      <Trans>played with delay</Trans>
    </Badge>
  );
}

/** Marks a game that was played in slow motion or frame by frame. */
export function PaceBadge({ recording }: { recording: Recording }) {
  const { slowest_percent: slowest, single_steps: steps } = recording;
  const parts = [];
  if (slowest !== null && slowest < 100) parts.push(t`slow motion, ${slowest}%`);
  if (steps) parts.push(plural(steps, { one: "# frame one by one", other: "# frames one by one" }));
  return parts.length === 0 ? null : <Badge>{parts.join("; ")}</Badge>;
}
