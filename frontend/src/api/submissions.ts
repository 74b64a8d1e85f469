/**
 * What is submitted twice is done once: a POST carries a key, and has the same one when it is sent
 * again before its outcome is known. The server does what has a key once.
 */
import { newUuid } from "@/lib/browser/uuid";
import { ofTab } from "@/lib/browser/storage";

const HEADER = "Idempotency-Key";
const STORAGE_KEY = "tril.submissions";

/** Afterwards the same content is another wish; the server keeps a game that nobody began longer. */
const KEPT_MS = 5 * 60_000;
const MOST_KEPT = 20;

/** [what was submitted, its key, when]: those whose outcome is not known. */
type Unsettled = readonly (readonly [content: string, key: string, at: number])[];

const inFlight = new Map<string, Promise<Response>>();

/** Sends a POST; one that is in flight already is not sent again, and has the same response. */
export async function submit(
  request: Request,
  send: (request: Request) => Promise<Response>,
): Promise<Response> {
  const content = await contentOf(request);
  let answer = inFlight.get(content);
  if (!answer) {
    request.headers.set(HEADER, keyOf(content));
    answer = send(request)
      .then((response) => {
        if (isSettled(response)) settle(content);
        return response;
      })
      .finally(() => inFlight.delete(content));
    inFlight.set(content, answer);
  }
  return (await answer).clone();
}

/** Whether nothing is left to be done: the server did it, or refused it. */
function isSettled({ status }: Response): boolean {
  return status < 500 && status !== 408 && status !== 429;
}

/** Returns an address and a digest of a body; the digest need only tell apart what a person sends. */
async function contentOf(request: Request): Promise<string> {
  const bytes = new Uint8Array(await request.clone().arrayBuffer());
  // FNV-1a; digests of the browser exist only on secure origins.
  let digest = 0x811c9dc5;
  for (const byte of bytes) digest = Math.imul(digest ^ byte, 0x01000193);
  return `${request.url} ${bytes.length} ${(digest >>> 0).toString(16)}`;
}

function keyOf(content: string): string {
  const kept = read();
  const known = kept.find(([one]) => one === content);
  if (known) return known[1];
  const key = newUuid();
  write([...kept, [content, key, Date.now()]]);
  return key;
}

function settle(content: string): void {
  write(read().filter(([one]) => one !== content));
}

function read(): Unsettled {
  const oldest = Date.now() - KEPT_MS;
  const kept = JSON.parse(ofTab.read(STORAGE_KEY) ?? "[]") as Unsettled;
  return kept.filter(([, , at]) => at > oldest);
}

function write(next: Unsettled): void {
  ofTab.write(STORAGE_KEY, JSON.stringify(next.slice(-MOST_KEPT)));
}
