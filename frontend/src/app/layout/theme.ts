/** The colour theme, stored in this browser. */
import { ofBrowser } from "@/lib/browser/storage";

const THEMES = ["system", "light", "dark"] as const;
type Theme = (typeof THEMES)[number];

const KEY = "tril.theme";

/** Returns the current theme. */
export function readTheme(): Theme {
  const chosen = document.documentElement.dataset.theme;
  return chosen === "light" || chosen === "dark" ? chosen : "system";
}

/** Applies and stores a theme; public/theme.js reads it before the first paint. */
export function applyTheme(theme: Theme): void {
  const root = document.documentElement;
  if (theme === "system") delete root.dataset.theme;
  else root.dataset.theme = theme;
  if (theme === "system") ofBrowser.remove(KEY);
  else ofBrowser.write(KEY, theme);
}

/** Returns the next theme, cyclically. */
export function nextTheme(theme: Theme): Theme {
  return THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length] ?? "system";
}
