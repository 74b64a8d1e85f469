import { MutationObserver, onlineManager, QueryObserver } from "@tanstack/react-query";
import { afterEach, expect, it, vi } from "vitest";

import { createQueryClient } from "@/app/query-client";

afterEach(() => onlineManager.setOnline(true));

it("asks and writes where the browser says that it is offline: Tril may run on this machine", async () => {
  const client = createQueryClient();
  client.mount();
  onlineManager.setOnline(false);
  const asked = vi.fn(() => Promise.resolve("answer"));
  const stop = new QueryObserver(client, {
    queryKey: ["any"],
    queryFn: asked,
    staleTime: 0,
  }).subscribe(() => undefined);
  await vi.waitFor(() => expect(client.getQueryData(["any"])).toBe("answer"));
  const writes = new MutationObserver(client, { mutationFn: asked });
  expect(await writes.mutate()).toBe("answer");
  expect(asked).toHaveBeenCalledTimes(2);
  // Back on the network, what may have changed meanwhile is asked for again.
  onlineManager.setOnline(true);
  await vi.waitFor(() => expect(asked).toHaveBeenCalledTimes(3));
  stop();
  client.unmount();
});
