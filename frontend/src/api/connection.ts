/** The connection state that the banner and the 401 page show. */

interface ConnectionState {
  /** False from a failed request until the next one that is answered. */
  readonly reachable: boolean;
  /** False once the server has rejected this browser's cookie. */
  readonly authorised: boolean;
  /** False while the change stream is silent: what is shown may be old. */
  readonly live: boolean;
}

type Listener = () => void;

class Connection {
  private state: ConnectionState = { reachable: true, authorised: true, live: true };
  private readonly listeners = new Set<Listener>();

  readonly subscribe = (listener: Listener): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): ConnectionState => this.state;

  update(change: Partial<ConnectionState>): void {
    const keys = Object.keys(change) as (keyof ConnectionState)[];
    if (keys.every((key) => change[key] === this.state[key])) return;
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}

export const connection = new Connection();
