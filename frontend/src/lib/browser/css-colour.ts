/** Resolves the page's colour tokens for canvas, which knows no CSS variables. */

/**
 * Returns the current colour of a CSS expression such as `var(--ink)`.
 *
 * @param inside The element whose theme applies: the game's screen is always dark.
 */
export function resolveColour(expression: string, inside: Element = document.body): string {
  const probe = document.createElement("span");
  probe.style.color = expression;
  inside.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

/** Calls back when the theme changes, in the system or on the page; returns an unsubscriber. */
export function onThemeChange(callback: () => void): () => void {
  const query = matchMedia("(prefers-color-scheme: dark)");
  query.addEventListener("change", callback);
  const observer = new MutationObserver(callback);
  observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  return () => {
    query.removeEventListener("change", callback);
    observer.disconnect();
  };
}
