/**
 * What changes on the server, told to every tab over one connection per browser. A browser allows
 * six connections per host over all its tabs, so one tab (the holder of a lock) keeps the stream
 * and passes what it hears on to the others.
 */

export interface Change {
  readonly topic: string;
  readonly key: string;
}

/** What tabs tell each other; `again`: the stream had broken off, so anything may have changed. */
type Message = { readonly kind: "change"; readonly change: Change } | { readonly kind: "again" };

export interface StreamListener {
  onChange(change: Change): void;
  /** The stream is back after a break; nothing that is shown can be relied on. */
  onAgain(): void;
}

const EVENTS_URL = "/api/events";
const LOCK = "tril-event-stream";
const CHANNEL = "tril-events";
/** After a refusal (such as 503) the browser gives up by itself; this is when to try anew. */
const RETRY_MS = 3000;

/** Listens until the returned function is called. */
export function listenToChanges(listener: StreamListener): () => void {
  const stop = new AbortController();
  const channel = new BroadcastChannel(CHANNEL);
  const hear = (message: Message) => {
    if (message.kind === "change") listener.onChange(message.change);
    else listener.onAgain();
  };
  channel.onmessage = (event: MessageEvent<Message>) => hear(event.data);
  stop.signal.addEventListener("abort", () => channel.close());

  const lead = () =>
    keepStream(stop.signal, (message) => {
      hear(message);
      channel.postMessage(message);
    });

  // Locks exist only on secure origins (https, or this machine itself). Without them each tab
  // keeps its own stream and the others hear everything twice, which does no harm.
  const locks = (navigator as Partial<Navigator>).locks;
  if (locks) {
    locks.request(LOCK, { signal: stop.signal }, lead).catch((error: unknown) => {
      if (!stop.signal.aborted) throw error;
    });
  } else {
    void lead();
  }
  return () => stop.abort();
}

/** Keeps the connection open until told to stop. */
function keepStream(signal: AbortSignal, tell: (message: Message) => void): Promise<void> {
  return new Promise((resolve) => {
    let source: EventSource;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let broken = false;

    const connect = () => {
      source = new EventSource(EVENTS_URL);
      source.addEventListener("open", () => {
        if (broken) tell({ kind: "again" });
        broken = false;
      });
      source.addEventListener("change", (event: MessageEvent<string>) => {
        tell({ kind: "change", change: JSON.parse(event.data) as Change });
      });
      source.addEventListener("error", () => {
        broken = true;
        if (source.readyState === EventSource.CLOSED) timer = setTimeout(connect, RETRY_MS);
      });
    };

    signal.addEventListener("abort", () => {
      clearTimeout(timer);
      source.close();
      resolve();
    });
    connect();
  });
}
