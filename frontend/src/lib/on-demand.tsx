import { type ComponentType, type FunctionComponent, lazy, useState } from "react";

/** A component whose code is loaded when it is first rendered, or before by `load`. */
export type OnDemand<Props> = FunctionComponent<Props> & { load: () => Promise<unknown> };

/**
 * Returns a component whose code is loaded on demand. React's `lazy` shows the fallback for a moment
 * even if the code is there; this one renders at once.
 */
export function onDemand<Props extends object>(
  importCode: () => Promise<ComponentType<Props>>,
): OnDemand<Props> {
  let loaded: ComponentType<Props> | undefined;
  const load = async () => {
    loaded = await importCode();
    return { default: loaded };
  };
  const Pending = lazy(load) as unknown as ComponentType<Props>;
  function Page(props: Props) {
    // Kept, so that nothing is mounted anew once the code is there.
    const [Shown] = useState(() => loaded ?? Pending);
    return <Shown {...props} />;
  }
  return Object.assign(Page, { load });
}
