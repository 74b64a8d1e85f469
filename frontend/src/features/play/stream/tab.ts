/** Returns the URL of a game's stream for a tab. */
export function streamUrl(streamPath: string, tab: string): string {
  const url = new URL(streamPath, location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.searchParams.set("tab", tab);
  return url.href;
}
