import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { openExample } from "@/api/runs";
import { systemQuery } from "@/api/system";
import { Button } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";

/** Opens the finished run that ships with Tril; nothing where none does. */
export function FinishedExampleButton() {
  const client = useQueryClient();
  const navigate = useNavigate();
  const toast = useToast();
  const { data: system } = useQuery(systemQuery);
  const open = useMutation({
    mutationFn: openExample,
    onSuccess: async (run) => {
      // Its behaviour is new, too.
      await Promise.all([
        client.invalidateQueries({ queryKey: ["runs"] }),
        client.invalidateQueries({ queryKey: ["behaviours"] }),
      ]);
      await navigate(`/runs/${run.id}`);
    },
    onError: (error) => toast(messageOf(error)),
  });
  if (!system?.has_example) return null;
  return (
    <Button
      large
      title={t`A run that ships with Tril: a scripted player made the games.`}
      disabled={open.isPending}
      onClick={() => open.mutate()}
    >
      {open.isPending ? (
        t`Opening…`
      ) : (
        <span>
          <Trans>
            Open a finished example <small>(at once)</small>
          </Trans>
        </span>
      )}
    </Button>
  );
}
