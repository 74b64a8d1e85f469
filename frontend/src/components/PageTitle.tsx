import { createContext, useContext } from "react";

/** What replaces every page's title, such as the progress of a run; null keeps it. */
export const TitleContext = createContext<string | null>(null);

/** The title of the browser's tab. */
export function PageTitle({ children }: { children: string }) {
  return <title>{useContext(TitleContext) ?? children}</title>;
}
