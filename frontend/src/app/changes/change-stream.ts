/**
 * The server's change stream, shared by all tabs of a browser. A browser allows six connections
 * per host, all tabs together, so one tab (the holder of a lock) keeps the stream and broadcasts
 * it to the others.
 */
import { SilenceWatch } from "@/lib/browser/silence";

export interface Change {
  readonly topic: string;
  readonly key: string;
}

/**
 * What tabs broadcast; after a reconnection anything may have changed, and so may it where another tab
 * has taken the stream over.
 */
type Message =
  | { readonly kind: "change"; readonly change: Change }
  | { readonly kind: "reconnected" }
  | { readonly kind: "heard" };

interface StreamListener {
  onChange(change: Change): void;
  /** The stream is back after an interruption; changes may have been missed. */
  onReconnect(): void;
  /** Whether anything was heard lately. */
  onLive(live: boolean): void;
}

const EVENTS_URL = "/api/events";
const LOCK = "tril-event-stream";
const CHANNEL = "tril-events";
/** The browser does not retry after an error response (such as 503), so this module does. */
const RETRY_MS = 3000;
/** The server says something every 5 s (server/change_stream.py). */
const SILENCE_MS = 10_000;
/**
 * The same of a stream that was opened anew. The browser may take a connection for it that it has kept
 * and that is as silent; each try uses one of them up.
 */
const REOPENED_MS = 3_000;

/** Subscribes to the server's changes; returns a function that unsubscribes. */
export function listenToChanges(listener: StreamListener): () => void {
  const stop = new AbortController();
  const channel = new BroadcastChannel(CHANNEL);
  let reopen: () => void = () => undefined;
  const silence = new SilenceWatch({
    onSilence: () => {
      listener.onLive(false);
      reopen();
      silence.start(REOPENED_MS);
    },
  });
  silence.start(SILENCE_MS);
  const dispatch = (message: Message) => {
    silence.heard(SILENCE_MS);
    listener.onLive(true);
    if (message.kind === "change") listener.onChange(message.change);
    if (message.kind === "reconnected") listener.onReconnect();
  };
  channel.onmessage = (event: MessageEvent<Message>) => dispatch(event.data);
  stop.signal.addEventListener("abort", () => {
    silence.stop();
    channel.close();
  });

  const stream = (takesOver: boolean) => {
    const kept = keepStream(stop.signal, takesOver, (message) => {
      dispatch(message);
      channel.postMessage(message);
    });
    reopen = kept.reopen;
    return kept.ended;
  };

  // Web Locks exist only on secure origins (https or localhost), and are denied where storage is.
  // Without them each tab keeps its own stream, and every tab is notified more than once, which is
  // harmless.
  const locks = (navigator as Partial<Navigator>).locks;
  if (locks) {
    locks
      .request(LOCK, { ifAvailable: true }, (lock) =>
        lock && !stop.signal.aborted ? stream(false) : undefined,
      )
      .then(() => locks.request(LOCK, { signal: stop.signal }, () => stream(true)))
      .catch(() => {
        if (!stop.signal.aborted) void stream(false);
      });
  } else {
    void stream(false);
  }
  return () => stop.abort();
}

interface KeptStream {
  /** Resolves when the signal has aborted. */
  readonly ended: Promise<void>;
  /** Replaces a connection that went silent. */
  readonly reopen: () => void;
}

/** Keeps the connection open until the signal aborts. */
function keepStream(
  signal: AbortSignal,
  takesOver: boolean,
  emit: (message: Message) => void,
): KeptStream {
  let source: EventSource;
  let timer: ReturnType<typeof setTimeout> | undefined;
  // Changes since the other tab was closed were told to nobody.
  let broken = takesOver;

  const connect = () => {
    source = new EventSource(EVENTS_URL);
    source.addEventListener("open", () => {
      emit({ kind: broken ? "reconnected" : "heard" });
      broken = false;
    });
    source.addEventListener("ping", () => emit({ kind: "heard" }));
    source.addEventListener("change", (event: MessageEvent<string>) => {
      emit({ kind: "change", change: JSON.parse(event.data) as Change });
    });
    source.addEventListener("error", () => {
      broken = true;
      if (source.readyState === EventSource.CLOSED) timer = setTimeout(connect, RETRY_MS);
    });
  };

  const close = () => {
    clearTimeout(timer);
    source.close();
  };
  connect();
  return {
    ended: new Promise((resolve) => {
      signal.addEventListener("abort", () => {
        close();
        resolve();
      });
    }),
    reopen: () => {
      close();
      broken = true;
      connect();
    },
  };
}
