import { Fragment, type ReactNode, useSyncExternalStore } from "react";

import { onLanguage, readLanguage } from "@/app/language";

/** Renders the page anew when its language changes, so that no text of the last one stays. */
export function Localised({ children }: { children: ReactNode }) {
  const language = useSyncExternalStore(onLanguage, readLanguage);
  return <Fragment key={language}>{children}</Fragment>;
}
